#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "calib/base/yaml_value.hpp"

namespace ceilmap {

/// The values that a number may have.
struct SettingRange {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool without_min = false;  ///< min itself is excluded
  bool without_max = false;

  static SettingRange AtLeast(double min) { return {.min = min}; }
  static SettingRange Above(double min) { return {.min = min, .without_min = true}; }
  static SettingRange Closed(double min, double max) { return {.min = min, .max = max}; }
  static SettingRange Open(double min, double max) {
    return {.min = min, .max = max, .without_min = true, .without_max = true};
  }
  static SettingRange LeftOpen(double min, double max) {
    return {.min = min, .max = max, .without_min = true};
  }

  [[nodiscard]] bool Contains(double value) const;
  [[nodiscard]] std::string Text() const;  ///< "> 0", ">= 1", "in (0, 1)"
};

/// One parameter that a settings file can set.
struct Setting {
  using Value = std::variant<double, int, bool, std::string>;

  std::string key;      ///< dotted, e.g. mapping.odometry.recent_keyframes
  std::string unit;     ///< empty: none
  std::string range;    ///< allowed values
  std::string meaning;  ///< one sentence
  std::function<Value()> get;
  std::function<void(const YamlValue&)> read;  ///< @throws InputError on a wrong type or value
};

/// The parameters of an object that a settings file can set. A copy refers to the same list.
///
/// A room describes its parameters by a function `void Describe(XParams&, const Settings&)`. The
/// described object must outlive the settings.
class Settings {
 public:
  /// The same list; keys that are added begin with `section` and a dot.
  [[nodiscard]] Settings In(std::string_view section) const;

  void Add(std::string_view key,
           double& value,
           std::string_view unit,
           const SettingRange& range,
           std::string_view meaning) const;
  void Add(std::string_view key,
           int& value,
           std::string_view unit,
           const SettingRange& range,
           std::string_view meaning) const;
  void Add(std::string_view key, bool& value, std::string_view meaning) const;
  template <typename Enum>
  void AddChoice(std::string_view key,
                 Enum& value,
                 const std::vector<std::pair<std::string, Enum>>& choices,
                 std::string_view meaning) const {
    std::vector<std::string> names;
    names.reserve(choices.size());
    for (const auto& choice : choices) names.push_back(choice.first);
    AddNamed(
        key,
        names,
        meaning,
        [&value, choices] {
          std::size_t i = 0;
          while (choices[i].second != value) ++i;
          return i;
        },
        [&value, choices](std::size_t i) { value = choices[i].second; });
  }

  [[nodiscard]] const std::vector<Setting>& List() const& { return *list_; }
  const std::vector<Setting>& List() const&& = delete;  // it may end with the object

  /// Sets the values that a YAML file gives; the others keep theirs.
  /// @throws InputError that names file, line and key, for a key that does not exist (with the most
  ///   similar one), a wrong type, or a value out of range.
  void Load(const std::filesystem::path& file) const;
  /// The same for a text. @param file  its name in messages.
  void Parse(const std::string& text, const std::filesystem::path& file) const;

 private:
  template <typename Number, typename Read>
  void AddNumber(std::string_view key,
                 Number& value,
                 std::string_view unit,
                 const SettingRange& range,
                 std::string_view meaning,
                 const Read& read) const;
  void AddNamed(std::string_view key,
                const std::vector<std::string>& names,
                std::string_view meaning,
                const std::function<std::size_t()>& get,
                const std::function<void(std::size_t)>& set) const;
  void Append(Setting setting) const;
  void ReadSection(const std::string& prefix, const YamlValue& section) const;

  std::string prefix_;
  std::shared_ptr<std::vector<Setting>> list_ = std::make_shared<std::vector<Setting>>();
};

/// A value as it stands in a settings file.
std::string FormatValue(const Setting::Value& value);
/// A complete settings file with the values that the settings have now; Load reads it.
std::string FormatSettingsFile(const Settings& settings);
/// A table in Markdown: key, unit, range, value and meaning.
std::string FormatSettingsTable(const Settings& settings);

}  // namespace ceilmap
