#pragma once

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace YAML {
class Node;
}

namespace ceilmap {

/// Limits of a settings file. A larger file is refused before memory is allocated for it. An alias
/// counts as one value.
inline constexpr std::size_t kMaxSettingsBytes = std::size_t{1} << 20U;
inline constexpr int kMaxSettingsDepth = 32;
inline constexpr int kMaxSettingsValues = 100000;

/// A value in a YAML settings file, read strictly. It stores its file, line and dotted key. Every
/// key that is missing, unknown, duplicated or of the wrong type causes an InputError of the form
///   FILE:LINE: KEY = VALUE, must be ...; how to fix it
/// on one line. A key whose value is null counts as absent.
class YamlValue {
 public:
  /// @param what  names the kind of file in messages, e.g. "a rig file".
  /// @throws InputError when `text` is not one YAML document that holds a map of keys, or exceeds
  ///   the limits above.
  static YamlValue Parse(const std::string& text,
                         const std::filesystem::path& file,
                         std::string_view what);

  /// The value under a key. @param fix what to write there when it is missing, for the message.
  [[nodiscard]] YamlValue At(std::string_view key, std::string_view fix) const;
  [[nodiscard]] std::optional<YamlValue> Find(std::string_view key) const;
  /// @throws InputError unless this is a map whose keys are all named here, each at most once.
  void AllowOnly(std::initializer_list<std::string_view> keys) const;

  /// The keys of this map with their values, in the order of the file; keys whose value is null are
  /// left out. @throws InputError unless this is a map in which each key is given once.
  [[nodiscard]] std::vector<std::pair<std::string, YamlValue>> Entries() const;

  std::string Text() const;
  double Number() const;  ///< finite
  double PositiveNumber(std::string_view fix) const;
  int WholeNumber(int least, int most) const;
  /// A list of exactly `count` finite numbers.
  std::vector<double> Numbers(std::size_t count) const;
  /// A list of any number of texts.
  std::vector<std::string> Texts() const;
  /// The number of entries when this is a list, else throws.
  std::size_t ListSize() const;
  /// The entries of a list of any values, with the keys KEY[0], KEY[1], ...
  [[nodiscard]] std::vector<YamlValue> Items() const;

  /// Throws "FILE:LINE: KEY = VALUE, must be MUST_BE; FIX".
  [[noreturn]] void Fail(std::string_view must_be, std::string_view fix) const;

  /// Throws "FILE:LINE: unknown key 'KEY'; did you mean 'MEANT'?"
  [[noreturn]] void FailUnknown(std::string_view meant) const;

  [[nodiscard]] const std::filesystem::path& File() const { return file_; }

 private:
  YamlValue() = default;
  [[nodiscard]] std::string Where() const;
  [[nodiscard]] YamlValue Child(std::string name, const YAML::Node& node, int line) const;

  std::filesystem::path file_;
  std::string key_;  // dotted, empty at the top
  int line_ = 0;     // from 1; 0: unknown
  std::shared_ptr<const YAML::Node> node_;
};

/// The whole text of a settings file.
/// @param what  as above. @throws InputError when it is missing, unreadable, a folder or larger
///   than 1 MiB.
std::string ReadSettingsText(const std::filesystem::path& file, std::string_view what);

}  // namespace ceilmap
