#pragma once

#include <string>

namespace ceilmap {

/// A text in double quotes, valid in YAML and JSON. Control characters become spaces.
std::string QuotedText(const std::string& text);

/// A number in the format of the settings files: at most nine decimal places and no superfluous
/// digits, so that rounding noise such as 1e-17 becomes 0.
/// @param value  finite.
std::string NumberText(double value);

}  // namespace ceilmap
