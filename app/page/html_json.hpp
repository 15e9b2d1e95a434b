#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace ceilmap::page {

/// JSON on one line that may stand in a script element of HTML, whatever its texts hold: without a
/// '<' no end of a script and no comment begins. Bytes that are not UTF-8 become U+FFFD.
std::string DumpForHtml(const nlohmann::ordered_json& json);

}  // namespace ceilmap::page
