#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace ceilmap {

/// A text that comes from a file or a library, for a message: runs of line breaks and blanks around
/// them become one blank, other control characters, which could command a terminal, become `?`.
/// @param max_bytes  of the text; what is longer is cut and ends in "...".
std::string InOneLine(std::string_view text, std::size_t max_bytes = std::string_view::npos);

}  // namespace ceilmap
