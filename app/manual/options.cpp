#include "app/manual/options.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace ceilmap::manual {
namespace {

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

}  // namespace

std::string ValueName(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':', type.starts_with('[') ? type.find(']') : 0));
}

std::vector<std::string> Choices(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find(":{");
  const std::size_t end = type.rfind('}');
  if (begin == std::string::npos || end == std::string::npos) return {};
  return Split(type.substr(begin + 2, end - begin - 2), ',');
}

std::vector<std::string> Extensions(const CLI::Option& option) {
  const std::string name = ValueName(option);
  const std::size_t dot = name.find_last_of('.');
  const auto lower = [](char c) { return (c >= 'a' && c <= 'z') || c == '|'; };
  if (dot == std::string::npos || dot + 1 == name.size()) return {};
  const std::string after = name.substr(dot + 1);
  return std::all_of(after.begin(), after.end(), lower) ? Split(after, '|')
                                                        : std::vector<std::string>{};
}

Value ValueOf(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return Value::kNone;
  if (!Choices(option).empty()) return Value::kChoice;
  if (!Extensions(option).empty()) return Value::kFile;
  const std::string name = ValueName(option);
  if (name.ends_with("DIR")) return Value::kFolder;
  constexpr std::array<std::string_view, 5> kFiles = {
      "SOURCE", "PATH", "WHEELS", "MODEL", "MODEL2"};
  return std::find(kFiles.begin(), kFiles.end(), name) != kFiles.end() ? Value::kFile
                                                                       : Value::kOther;
}

std::vector<std::string> Names(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::string FullName(const CLI::App& command) {
  const CLI::App* const parent = command.get_parent();
  return parent == nullptr ? command.get_name() : FullName(*parent) + " " + command.get_name();
}

std::vector<const CLI::App*> Commands(const CLI::App& command) {
  return command.get_subcommands({});
}

}  // namespace ceilmap::manual
