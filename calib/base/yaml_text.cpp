#include "calib/base/yaml_text.hpp"

#include <fmt/format.h>

namespace ceilmap {

std::string QuotedText(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return quoted + '"';
}

std::string NumberText(double value) {
  const std::string text = fmt::format("{:.9f}", value);
  return fmt::format("{:.12g}", std::stod(text) + 0.0);  // "-0" becomes 0
}

}  // namespace ceilmap
