#pragma once

#include <string>

namespace ceilmap {

/// A text in double quotes, as YAML and JSON read it. Control characters, which have no place in a
/// name, become spaces.
std::string QuotedText(const std::string& text);

/// A number as files of settings write it: to nine places after the point, and no more digits than
/// it needs, so that rounding noise such as 1e-17 is 0.
/// @param value  finite.
std::string NumberText(double value);

}  // namespace ceilmap
