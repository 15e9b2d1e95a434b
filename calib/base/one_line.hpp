#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ceilmap {

/// Converts a text from a file or a library to one line for a message. Line breaks with the blanks
/// around them become one blank. Other control characters, which could control a terminal, become
/// `?`.
/// @param max_bytes maximum length of the text; a longer text is cut and ends in "...".
std::string InOneLine(std::string_view text, std::size_t max_bytes = std::string_view::npos);

/// The start of a text from a file for a message, without a part of a UTF-8 character. Control
/// characters become `?`.
std::string Shown(std::string_view text, std::size_t max_bytes = 60);

}  // namespace ceilmap
