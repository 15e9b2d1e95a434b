#include "calib/base/one_line.hpp"

#include <algorithm>

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

std::string Shown(std::string_view text, std::size_t max_bytes) {
  std::size_t end = std::min(text.size(), max_bytes);
  // Not amid a character of UTF-8.
  const auto continues = [&](std::size_t at) {
    return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
  };
  while (end > 0 && end < text.size() && continues(end)) --end;
  std::string shown(text.substr(0, end));
  const auto commands = [](unsigned char c) { return c < ' ' || c == 127; };
  std::replace_if(shown.begin(), shown.end(), commands, '?');
  return end < text.size() ? shown + "..." : shown;
}

}  // namespace ceilmap
