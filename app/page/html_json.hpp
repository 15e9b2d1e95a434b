#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace ceilmap::page {

/// JSON on one line that is safe in a script element of HTML, whatever its texts contain: without
/// '<', it cannot end the script or begin a comment. Bytes that are not UTF-8 become U+FFFD.
std::string DumpForHtml(const nlohmann::ordered_json& json);

}  // namespace ceilmap::page
