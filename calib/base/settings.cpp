#include "calib/base/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "calib/base/similar_word.hpp"

namespace ceilmap {
namespace {

constexpr std::string_view kWhat = "a settings file";

std::string_view LastName(std::string_view key) {
  const std::size_t dot = key.rfind('.');
  return dot == std::string_view::npos ? key : key.substr(dot + 1);
}

/// The keys, and the sections that hold them.
std::set<std::string> KeysAndSections(const std::vector<Setting>& list) {
  std::set<std::string> names;
  for (const Setting& setting : list) {
    for (std::size_t dot = setting.key.find('.'); dot != std::string::npos;
         dot = setting.key.find('.', dot + 1)) {
      names.insert(setting.key.substr(0, dot));
    }
    names.insert(setting.key);
  }
  return names;
}

/// The most similar key. A name of the same section is preferred to one of another section.
std::string MostSimilar(const std::vector<Setting>& list, const std::string& key) {
  std::string best;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const std::string& known : KeysAndSections(list)) {
    const std::size_t by_name = EditDistance(LastName(known), LastName(key));
    const std::size_t distance = 2 * by_name + EditDistance(known, key);
    if (distance >= least) continue;
    least = distance;
    best = known;
  }
  return best;
}

template <typename Number>
void CheckRange(const YamlValue& given, Number value, const SettingRange& range) {
  if (!range.Contains(static_cast<double>(value))) given.Fail(range.Text(), "correct the value");
}

/// "a, b or c"
std::string Either(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += i == 0 ? "" : i + 1 == names.size() ? " or " : ", ";
    text += names[i];
  }
  return text;
}

}  // namespace

bool SettingRange::Contains(double value) const {
  return (without_min ? value > min : value >= min) && (without_max ? value < max : value <= max);
}

std::string SettingRange::Text() const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (max == kInfinity) {
    return min == -kInfinity ? "any" : fmt::format("{} {}", without_min ? ">" : ">=", min);
  }
  return fmt::format("in {}{}, {}{}", without_min ? '(' : '[', min, max, without_max ? ')' : ']');
}

Settings Settings::In(std::string_view section) const {
  Settings inner = *this;
  inner.prefix_ += fmt::format("{}.", section);
  return inner;
}

void Settings::Append(Setting setting) const {
  setting.key = prefix_ + setting.key;
  list_->push_back(std::move(setting));
}

template <typename Number, typename Read>
void Settings::AddNumber(std::string_view key,
                         Number& value,
                         std::string_view unit,
                         const SettingRange& range,
                         std::string_view meaning,
                         const Read& read) const {
  Append({std::string(key),
          std::string(unit),
          range.Text(),
          std::string(meaning),
          [&value]() -> Setting::Value { return value; },
          [&value, range, read](const YamlValue& given) {
            const Number number = read(given);
            CheckRange(given, number, range);
            value = number;
          }});
}

void Settings::Add(std::string_view key,
                   double& value,
                   std::string_view unit,
                   const SettingRange& range,
                   std::string_view meaning) const {
  AddNumber(
      key, value, unit, range, meaning, [](const YamlValue& given) { return given.Number(); });
}

void Settings::Add(std::string_view key,
                   int& value,
                   std::string_view unit,
                   const SettingRange& range,
                   std::string_view meaning) const {
  AddNumber(key, value, unit, range, meaning, [](const YamlValue& given) {
    using Limits = std::numeric_limits<int>;
    return static_cast<int>(given.WholeNumber(Limits::min(), Limits::max()));
  });
}

void Settings::Add(std::string_view key, bool& value, std::string_view meaning) const {
  AddNamed(
      key,
      {"false", "true"},
      meaning,
      [&value] { return value ? std::size_t{1} : std::size_t{0}; },
      [&value](std::size_t i) { value = i == 1; });
  list_->back().get = [&value]() -> Setting::Value { return value; };
}

void Settings::AddNamed(std::string_view key,
                        const std::vector<std::string>& names,
                        std::string_view meaning,
                        const std::function<std::size_t()>& get,
                        const std::function<void(std::size_t)>& set) const {
  Append({std::string(key),
          "",
          Either(names),
          std::string(meaning),
          [names, get]() -> Setting::Value { return names[get()]; },
          [names, set](const YamlValue& given) {
            const auto found = std::find(names.begin(), names.end(), given.Text());
            if (found == names.end()) given.Fail(Either(names), "correct the value");
            set(static_cast<std::size_t>(found - names.begin()));
          }});
}

void Settings::ReadSection(const std::string& prefix, const YamlValue& section) const {
  for (const auto& [name, given] : section.Entries()) {
    std::string key = prefix;
    if (!key.empty()) key += '.';
    key += name;
    const auto setting = std::find_if(
        list_->begin(), list_->end(), [&key](const Setting& known) { return known.key == key; });
    if (setting != list_->end()) {
      setting->read(given);
      continue;
    }
    if (!KeysAndSections(*list_).contains(key)) given.FailUnknown(MostSimilar(*list_, key));
    ReadSection(key, given);
  }
}

void Settings::Parse(const std::string& text, const std::filesystem::path& file) const {
  ReadSection("", YamlValue::Parse(text, file, kWhat));
}

void Settings::Load(const std::filesystem::path& file) const {
  Parse(ReadSettingsText(file, kWhat), file);
}

std::string FormatValue(const Setting::Value& value) {
  return std::visit([](const auto& plain) { return fmt::format("{}", plain); }, value);
}

std::string FormatSettingsFile(const Settings& settings) {
  std::string text;
  std::vector<std::string> open;  // sections around the last key
  for (const Setting& setting : settings.List()) {
    std::vector<std::string> sections;
    std::size_t start = 0;
    for (std::size_t dot = setting.key.find('.'); dot != std::string::npos;
         dot = setting.key.find('.', start)) {
      sections.push_back(setting.key.substr(start, dot - start));
      start = dot + 1;
    }
    const auto [differs, same] =
        std::mismatch(sections.begin(), sections.end(), open.begin(), open.end());
    for (auto section = differs; section != sections.end(); ++section) {
      const auto depth = static_cast<std::size_t>(section - sections.begin());
      text += fmt::format("{}{}:\n", std::string(2 * depth, ' '), *section);
    }
    open = sections;
    const std::string indent(2 * sections.size(), ' ');
    text += fmt::format("{}{}: {}  # {}{}\n",
                        indent,
                        setting.key.substr(start),
                        FormatValue(setting.get()),
                        setting.unit.empty() ? "" : setting.unit + ", ",
                        setting.range);
  }
  return text;
}

std::string FormatSettingsTable(const Settings& settings) {
  std::string text = "| name | unit | range | default | meaning |\n|---|---|---|---|---|\n";
  for (const Setting& setting : settings.List()) {
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n",
                        setting.key,
                        setting.unit,
                        setting.range,
                        FormatValue(setting.get()),
                        setting.meaning);
  }
  return text;
}

}  // namespace ceilmap
