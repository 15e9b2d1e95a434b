#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ceilmap::commands {

/// Topics of `ceilmap help` that are no commands: "files", "troubleshooting".
std::vector<std::string> HelpTopics();

/// The text of a topic, in upper or lower case; nothing when there is no such topic.
std::optional<std::string> HelpOn(std::string_view topic);

/// The rows of a Markdown table of three columns, without its heading, as paragraphs for a
/// terminal: the first cell, and the others indented below it. Lines have at most 90 characters,
/// except for longer words. Other lines of the text are kept.
std::string TableAsParagraphs(std::string_view markdown);

}  // namespace ceilmap::commands
