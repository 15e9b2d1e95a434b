#include "calib/base/one_line.hpp"

namespace ceilmap {

std::string InOneLine(std::string_view text, std::size_t max_bytes) {
  std::string line;
  bool gap = false;
  for (const char c : text.substr(0, max_bytes)) {
    if (c == '\n' || c == '\r') {
      gap = true;
    } else if (!gap || c != ' ') {
      if (gap && !line.empty() && line.back() != ' ') line += ' ';
      gap = false;
      const auto byte = static_cast<unsigned char>(c);
      line += (byte < ' ' && c != '\t') || byte == 127 ? '?' : c;
    }
  }
  if (text.size() > max_bytes) line += "...";
  return line;
}

}  // namespace ceilmap
