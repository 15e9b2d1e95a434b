#include "calib/base/remote_name.hpp"

#include <algorithm>
#include <cctype>

namespace ceilmap {
namespace {

constexpr std::string_view kHidden = "***";

bool StartsWith(std::string_view text, std::string_view start) {
  return text.size() >= start.size() &&
         std::equal(start.begin(), start.end(), text.begin(), [](char a, char b) {
           return a == std::tolower(static_cast<unsigned char>(b));
         });
}

bool IsWebAddress(std::string_view text) {
  return StartsWith(text, "http://") || StartsWith(text, "https://") ||
         StartsWith(text, "/vsicurl/") || StartsWith(text, "/vsicurl?");
}

/// End of the value at `begin` of a connection string: 'quoted', or up to a blank or an ampersand.
std::size_t EndOfValue(std::string_view text, std::size_t begin) {
  const bool quoted = begin < text.size() && text[begin] == '\'';
  for (std::size_t i = begin + (quoted ? 1 : 0); i < text.size(); ++i) {
    if (text[i] == '\\') {
      ++i;  // the next character belongs to the value
    } else if (quoted ? text[i] == '\'' : (text[i] == ' ' || text[i] == '&')) {
      return quoted ? i + 1 : i;
    }
  }
  return text.size();
}

/// Values of `password = ...` (and `sslpassword`).
std::string WithoutPasswords(std::string_view text) {
  constexpr std::string_view kKey = "password";
  std::string shown;
  for (std::size_t i = 0; i < text.size();) {
    if (!StartsWith(text.substr(i), kKey)) {
      shown += text[i++];
      continue;
    }
    std::size_t at = i + kKey.size();
    while (at < text.size() && text[at] == ' ') ++at;
    if (at == text.size() || text[at] != '=') {
      shown += text[i++];
      continue;
    }
    ++at;
    while (at < text.size() && text[at] == ' ') ++at;
    shown += text.substr(i, at - i);
    shown += kHidden;
    i = EndOfValue(text, at);
  }
  return shown;
}

/// Of `scheme://user:password@host`. The last @ before the path ends the password, which may hold
/// others.
std::string WithoutUserPassword(std::string text) {
  const std::size_t scheme = text.find("://");
  if (scheme == std::string::npos) return text;
  const std::size_t begin = scheme + 3;
  const std::size_t end = std::min(text.find_first_of("/?#", begin), text.size());
  const std::size_t at = text.substr(0, end).rfind('@');
  if (at == std::string::npos || at < begin) return text;
  const std::size_t colon = text.find(':', begin);
  if (colon < at) text.replace(colon + 1, at - colon - 1, kHidden);
  return text;
}

}  // namespace

bool IsRemoteName(std::string_view name) {
  return IsWebAddress(name) || StartsWith(name, "/vsis3/");
}

std::string WithoutSecrets(std::string_view text) {
  std::string shown = WithoutPasswords(WithoutUserPassword(std::string(text)));
  const std::size_t query = shown.find('?', StartsWith(text, "/vsicurl?") ? 9 : 0);
  if (IsWebAddress(text) && query != std::string::npos) {
    shown.replace(query + 1, std::string::npos, kHidden);
  }
  return shown;
}

}  // namespace ceilmap
