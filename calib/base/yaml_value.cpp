#include "calib/base/yaml_value.hpp"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <system_error>

#include "calib/base/error.hpp"

namespace ceilmap {
namespace {

constexpr std::size_t kMaxShownBytes = 60;
constexpr std::size_t kMaxShownItems = 16;

/// Names, values and parser messages come from files and may contain anything; the error is always
/// one line.
[[noreturn]] void Throw(std::string message) {
  std::replace_if(
      message.begin(), message.end(), [](unsigned char c) { return c < ' ' || c == 127; }, '?');
  throw InputError(message);
}

std::string Shorten(std::string text) {
  if (text.size() <= kMaxShownBytes) return text;
  std::size_t end = kMaxShownBytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "...";
}

bool IsQuoted(const YAML::Node& node) {
  return node.IsScalar() && node.Tag() == "!";
}

std::string ShowScalar(const YAML::Node& node) {
  if (!node.IsScalar()) return node.IsNull() ? "null" : "...";
  return IsQuoted(node) ? '"' + Shorten(node.Scalar()) + '"' : Shorten(node.Scalar());
}

/// Descends one level at most, because a malicious file may contain itself through an alias.
std::string Show(const YAML::Node& node) {
  if (node.IsMap()) return "{...}";
  if (!node.IsSequence()) return ShowScalar(node);
  std::string text = "[";
  for (std::size_t i = 0; i < std::min(node.size(), kMaxShownItems); ++i) {
    text += (i == 0 ? "" : ", ") + ShowScalar(node[i]);
  }
  return text + (node.size() > kMaxShownItems ? ", ...]" : "]");
}

int LineOf(const YAML::Node& node) {
  return node.Mark().line + 1;  // yaml-cpp counts from 0 and uses -1 for "unknown"
}

/// Checks a text before nodes are created from it, because each node needs some hundred bytes and
/// yaml-cpp recurses for each level. It rejects sizes that no settings file has. An alias counts as
/// one value regardless of its content, and this reader never expands one.
class LimitGuard final : public YAML::EventHandler {
 public:
  LimitGuard(const std::filesystem::path& file, std::string fix)
      : file_(file), fix_(std::move(fix)) {}

  void OnDocumentStart(const YAML::Mark& mark) override { Count(mark); }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { Count(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { Count(mark); }
  void OnScalar(const YAML::Mark& mark,
                const std::string& /*tag*/,
                YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {
    Count(mark);
  }
  void OnSequenceStart(const YAML::Mark& mark,
                       const std::string& /*tag*/,
                       YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {
    Descend(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark,
                  const std::string& /*tag*/,
                  YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {
    Descend(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void Count(const YAML::Mark& mark) {
    if (++values_ > kMaxSettingsValues) Refuse(mark, "more than", kMaxSettingsValues, "values");
  }
  void Descend(const YAML::Mark& mark) {
    Count(mark);
    if (++depth_ > kMaxSettingsDepth)
      Refuse(mark, "nested deeper than", kMaxSettingsDepth, "levels");
  }
  [[noreturn]] void Refuse(const YAML::Mark& mark,
                           const std::string& what,
                           int most,
                           const std::string& unit) const {
    Throw(file_.string() + ":" + std::to_string(mark.line + 1) + ": " + what + " " +
          std::to_string(most) + " " + unit + fix_);
  }

  const std::filesystem::path& file_;
  std::string fix_;
  int values_ = 0;
  int depth_ = 0;
};

std::vector<YAML::Node> LoadDocuments(const std::string& text,
                                      const std::filesystem::path& file,
                                      std::string_view what) {
  const std::string fix = "; correct it there, or give " + std::string(what);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    LimitGuard guard(file, fix);
    while (parser.HandleNextDocument(guard)) {
    }
    return YAML::LoadAll(text);
  } catch (const InputError&) {
    throw;
  } catch (const YAML::Exception& error) {
    const std::string line = error.mark.is_null() ? "" : ":" + std::to_string(error.mark.line + 1);
    Throw(file.string() + line + ": not YAML: " + Shorten(error.msg) + fix);
  } catch (const std::exception& error) {
    Throw(file.string() + ": not YAML: " + Shorten(error.what()) + fix);
  }
}

/// The number in a plain scalar, or nothing.
template <typename T>
std::optional<T> ParseNumber(const YAML::Node& node) {
  if (!node.IsScalar() || IsQuoted(node)) return std::nullopt;
  const std::string& text = node.Scalar();
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const char* end = text.data() + text.size();
  T value{};
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error != std::errc{} || rest != end) return std::nullopt;
  return value;
}

std::string Join(std::initializer_list<std::string_view> words) {
  std::string text;
  for (const std::string_view word : words) {
    text += (text.empty() ? "" : ", ") + std::string(word);
  }
  return text;
}

}  // namespace

YamlValue YamlValue::Parse(const std::string& text,
                           const std::filesystem::path& file,
                           std::string_view what) {
  const std::vector<YAML::Node> documents = LoadDocuments(text, file, what);
  const std::string fix = "; give " + std::string(what);
  if (documents.empty() || documents[0].IsNull()) Throw(file.string() + ": is empty" + fix);
  if (documents.size() > 1) {
    Throw(file.string() + ":" + std::to_string(LineOf(documents[1])) + ": holds " +
          std::to_string(documents.size()) + " YAML documents, must be one" + fix);
  }
  if (!documents[0].IsMap()) {
    Throw(file.string() + ":" + std::to_string(LineOf(documents[0])) + ": " + Show(documents[0]) +
          " stands alone, must be a map of keys" + fix);
  }
  YamlValue root;
  root.file_ = file;
  root.line_ = LineOf(documents[0]);
  root.node_ = std::make_shared<const YAML::Node>(documents[0]);
  return root;
}

std::string YamlValue::Where() const {
  if (line_ <= 0) return fmt::format("{}: ", file_.string());
  return fmt::format("{}:{}: ", file_.string(), line_);
}

YamlValue YamlValue::Child(std::string name, const YAML::Node& node, int line) const {
  YamlValue child;
  child.file_ = file_;
  child.key_ = key_.empty() ? std::move(name) : key_ + "." + name;
  child.line_ = node.IsScalar() && LineOf(node) > 0 ? LineOf(node) : line;
  child.node_ = std::make_shared<const YAML::Node>(node);
  return child;
}

void YamlValue::Fail(std::string_view must_be, std::string_view fix) const {
  Throw(Where() + key_ + " = " + Show(*node_) + ", must be " + std::string(must_be) + "; " +
        std::string(fix));
}

void YamlValue::FailUnknown(std::string_view meant) const {
  Throw(fmt::format("{}unknown key '{}'; did you mean '{}'?", Where(), key_, meant));
}

YamlValue YamlValue::At(std::string_view key, std::string_view fix) const {
  if (std::optional<YamlValue> child = Find(key)) return *std::move(child);
  const std::string name = (key_.empty() ? "" : key_ + ".") + std::string(key);
  Throw(Where() + name + " is missing, must be given; add " + std::string(fix));
}

std::optional<YamlValue> YamlValue::Find(std::string_view key) const {
  if (!node_->IsMap()) Fail("a map of keys", "write 'key: value' lines below it");
  for (const auto& entry : *node_) {
    if (!entry.first.IsScalar() || entry.first.Scalar() != key) continue;
    if (entry.second.IsNull()) return std::nullopt;
    return Child(std::string(key), entry.second, LineOf(entry.first));
  }
  return std::nullopt;
}

void YamlValue::AllowOnly(std::initializer_list<std::string_view> keys) const {
  if (!node_->IsMap()) Fail("a map of keys", "write 'key: value' lines below it");
  std::set<std::string> seen;
  for (const auto& entry : *node_) {
    const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : Show(entry.first);
    const YamlValue child = Child(Shorten(name), entry.second, LineOf(entry.first));
    if (std::find(keys.begin(), keys.end(), name) == keys.end()) {
      Throw(child.Where() + child.key_ + " = " + Show(entry.second) +
            " is an unknown key, must be one of " + Join(keys) +
            "; correct its spelling or remove it");
    }
    if (!seen.insert(name).second) child.Fail("given once", "remove one of the two");
  }
}

std::vector<std::pair<std::string, YamlValue>> YamlValue::Entries() const {
  if (!node_->IsMap()) Fail("a map of keys", "write 'key: value' lines below it");
  std::vector<std::pair<std::string, YamlValue>> entries;
  std::set<std::string> seen;
  for (const auto& entry : *node_) {
    const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : Show(entry.first);
    YamlValue child = Child(Shorten(name), entry.second, LineOf(entry.first));
    if (!seen.insert(name).second) child.Fail("given once", "remove one of the two");
    if (!entry.second.IsNull()) entries.emplace_back(name, std::move(child));
  }
  return entries;
}

std::string YamlValue::Text() const {
  if (!node_->IsScalar()) Fail("a text", "write one word or a quoted text");
  return node_->Scalar();
}

double YamlValue::Number() const {
  const std::optional<double> value = ParseNumber<double>(*node_);
  if (!value || !std::isfinite(*value)) {
    Fail("a finite number", "write it plainly, e.g. 0.45, without quotes or unit");
  }
  return *value;
}

double YamlValue::PositiveNumber(std::string_view fix) const {
  const double value = Number();
  if (!(value > 0)) Fail("> 0", fix);
  return value;
}

int YamlValue::WholeNumber(int least, int most) const {
  const std::optional<int> value = ParseNumber<int>(*node_);
  if (!value || *value < least || *value > most) {
    const std::string range =
        least == most ? std::to_string(least)
                      : "a whole number in " + std::to_string(least) + ".." + std::to_string(most);
    Fail(range, "correct the value");
  }
  return *value;
}

std::size_t YamlValue::ListSize() const {
  if (!node_->IsSequence()) Fail("a list of numbers", "write it as [1, 2, 3]");
  return node_->size();
}

std::vector<double> YamlValue::Numbers(std::size_t count) const {
  if (ListSize() != count) {
    Fail("a list of " + std::to_string(count) + " numbers, not " + std::to_string(node_->size()),
         "complete or shorten the list");
  }
  std::vector<double> numbers;
  numbers.reserve(count);
  std::size_t index = 0;
  for (const auto& item : *node_) {
    YamlValue entry = Child("", item, line_);
    entry.key_ = key_ + "[" + std::to_string(index++) + "]";
    numbers.push_back(entry.Number());
  }
  return numbers;
}

std::vector<std::string> YamlValue::Texts() const {
  if (!node_->IsSequence()) Fail("a list of texts", "write it as [one, two]");
  std::vector<std::string> texts;
  for (const auto& item : *node_) {
    YamlValue entry = Child("", item, line_);
    entry.key_ = key_ + "[" + std::to_string(texts.size()) + "]";
    texts.push_back(entry.Text());
  }
  return texts;
}

std::vector<YamlValue> YamlValue::Items() const {
  if (!node_->IsSequence()) Fail("a list", "write '- value' lines below it, or [one, two]");
  std::vector<YamlValue> items;
  for (const auto& item : *node_) {
    YamlValue entry = Child("", item, LineOf(item) > 0 ? LineOf(item) : line_);
    entry.key_ = key_ + "[" + std::to_string(items.size()) + "]";
    items.push_back(std::move(entry));
  }
  return items;
}

std::string ReadSettingsText(const std::filesystem::path& file, std::string_view what) {
  const std::string fix = "; give the path of " + std::string(what);
  std::error_code status_error;
  if (std::filesystem::is_directory(file, status_error)) {
    Throw(file.string() + ": is a folder, must be a file" + fix);
  }
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    Throw(file.string() + ": " + std::generic_category().message(errno != 0 ? errno : EIO) + fix);
  }
  std::string text(kMaxSettingsBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (stream.bad()) Throw(file.string() + ": cannot be read" + fix);
  if (text.size() > kMaxSettingsBytes) Throw(file.string() + ": larger than 1 MiB" + fix);
  return text;
}

}  // namespace ceilmap
