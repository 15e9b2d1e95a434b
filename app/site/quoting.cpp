#include "app/site/quoting.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"

namespace ceilmap::site {
namespace {

/// A backslash makes them part of a name; without it they separate, comment or match.
constexpr std::string_view kEscapedByMake = " #:*?[~";
/// No writing of these means the same in targets and in prerequisites (GNU make 4.3).
constexpr std::string_view kNotForMake = "\\%=;|()\t\n\r";

}  // namespace

std::string ShellWord(std::string_view text) {
  std::string word = "'";
  for (const char byte : text) word += byte == '\'' ? std::string("'\\''") : std::string(1, byte);
  return word + "'";
}

std::string RecipeWord(std::string_view text) {
  if (text.find_first_of("\n\r") != std::string_view::npos) {
    throw InputError(
        fmt::format("'{}': has a line break, which a makefile cannot express", InOneLine(text)));
  }
  std::string word;
  for (const char byte : ShellWord(text))
    word += byte == '$' ? std::string("$$") : std::string(1, byte);
  return word;
}

std::string MakeName(std::string_view file) {
  if (const std::size_t at = file.find_first_of(kNotForMake); at != std::string_view::npos) {
    throw InputError(fmt::format(
        "'{}': a makefile cannot express names with '{}'; rename it, or use 'ceilmap site run'",
        InOneLine(file),
        InOneLine(file.substr(at, 1))));
  }
  std::string name;
  for (const char byte : file) {
    if (byte == '$') name += '$';
    if (kEscapedByMake.find(byte) != std::string_view::npos) name += '\\';
    name += byte;
  }
  return name;
}

}  // namespace ceilmap::site
