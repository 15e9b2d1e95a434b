#include "app/site/manifest.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/yaml_value.hpp"

namespace fs = std::filesystem;

namespace ceilmap::site {
namespace {

constexpr std::string_view kWhat = "a site's manifest (ceilmap help files: SITE.yaml)";
constexpr int kMaxPriority = 1000000;
constexpr std::size_t kMaxNameBytes = 80;
constexpr int kMaxMosaicParts = 10000;

/// An option of a step that must not stand in the manifest's options.
struct Refused {
  std::string_view option;
  std::string_view reason;
};

constexpr std::string_view kSetByPlan = "without it: the plan sets it";

constexpr std::array<Refused, 9> kNotOfMap{{
    {"--append", "without it: each recording has a map of its own"},
    {"--rig", "without it: it is the key 'rig' of a recording"},
    {"--up", "without it: it is the key 'up' of a recording"},
    {"--stamps", "without it: it is the key 'stamps' of a recording"},
    {"--odometry", "without it: it is the key 'odometry' of a recording"},
    {"--gyro", "without it: it is the key 'gyro' of a recording"},
    {"--forward", "without it: it is the key 'forward' of a recording"},
    {"--edges", kSetByPlan},
    {"--no-mosaic", "without it: the plan sets it by 'mosaic_parts'"},
}};

/// Options of `map` that name a file or folder of results.
constexpr std::array<std::string_view, 6> kResultsOfMap{
    "--trajectory", "--uncompensated", "--picture", "--report", "--rig-out", "--summary"};

/// A text that is passed to a program: one line.
std::string Line(const YamlValue& value) {
  std::string text = value.Text();
  if (text.empty()) value.Fail("a text that is not empty", "write it, or remove the key");
  const bool control = std::any_of(
      text.begin(), text.end(), [](unsigned char byte) { return byte < ' ' || byte == 127; });
  if (control) value.Fail("one line without control characters", "rename the file");
  return text;
}

/// A path, which no program takes for an option.
std::string Path(const YamlValue& value) {
  std::string text = Line(value);
  return text.starts_with('-') ? "./" + text : text;
}

std::string ExistingPath(const YamlValue& value, const fs::path& folder) {
  std::string text = Path(value);
  std::error_code ignored;
  if (!fs::exists(folder / text, ignored)) {
    value.Fail("a file that exists", "paths count from the manifest's folder");
  }
  return text;
}

/// A SOURCE: what is no pattern and no URL must exist.
std::string Source(const YamlValue& value, const fs::path& folder) {
  std::string text = Path(value);
  if (text.find("://") != std::string::npos || text.find('%') != std::string::npos) return text;
  std::error_code ignored;
  if (fs::is_character_file(folder / text, ignored)) {
    value.Fail("a recording, not a camera", "record it first");
  }
  return ExistingPath(value, folder);
}

std::string MapName(const YamlValue& value, std::string text) {
  if (fs::path(text).extension() != ".gpkg" || fs::path(text).stem().empty()) {
    value.Fail("a name that ends in .gpkg", "write e.g. site.gpkg");
  }
  return text;
}

bool IsSafe(unsigned char byte) {
  return std::isalnum(byte) != 0 || byte == '.' || byte == '_' || byte == '-';
}

/// `--` separates the two names of a match.
bool IsSafeName(const std::string& name) {
  return !name.empty() && name.size() <= kMaxNameBytes && name.front() != '.' &&
         name.front() != '-' && name.back() != '-' && name.find("--") == std::string::npos &&
         std::all_of(name.begin(), name.end(), IsSafe);
}

/// A safe name from that of a file.
std::string SafeNameOf(const std::string& path) {
  fs::path file(path);
  if (!file.has_filename()) file = file.parent_path();
  std::string name;
  for (const char byte : file.stem().string().substr(0, kMaxNameBytes)) {
    const char safe = IsSafe(static_cast<unsigned char>(byte)) ? byte : '_';
    const bool start = name.empty() && (safe == '.' || safe == '-');
    const bool again = safe == '-' && name.ends_with('-');
    if (!start && !again) name += safe;
  }
  while (name.ends_with('-')) name.pop_back();
  return name.empty() ? "recording" : name;
}

void CheckOption(const YamlValue& value, const std::string& word, bool of_all_maps) {
  const std::string option = word.substr(0, word.find('='));
  if (word.starts_with("-o") || option == "--output" || option == "--force" || word == "--") {
    value.Fail("an option that leaves the results' names alone",
               "remove it: the plan names the results");
  }
  for (const Refused& refused : kNotOfMap) {
    if (option == refused.option) value.Fail(refused.reason, "remove it from the options");
  }
  const bool result =
      std::find(kResultsOfMap.begin(), kResultsOfMap.end(), option) != kResultsOfMap.end();
  if (result && of_all_maps) {
    value.Fail("in the options of one recording, because all would write the same file",
               "move it there");
  }
}

std::vector<std::string> Options(const YamlValue& list, bool of_all_maps) {
  std::vector<std::string> words;
  for (const YamlValue& item : list.Items()) {
    words.push_back(Line(item));
    CheckOption(item, words.back(), of_all_maps);
  }
  return words;
}

StepOptions ReadOptions(const YamlValue& value) {
  value.AllowOnly({"map", "match", "solve", "align", "mosaic_parts"});
  StepOptions options;
  const std::initializer_list<std::pair<std::string_view, std::vector<std::string>*>> steps = {
      {"map", &options.map},
      {"match", &options.match},
      {"solve", &options.solve},
      {"align", &options.align}};
  for (const auto& [key, words] : steps) {
    if (const auto list = value.Find(key)) *words = Options(*list, key == "map");
  }
  if (const auto parts = value.Find("mosaic_parts")) {
    options.mosaic_parts = parts->WholeNumber(1, kMaxMosaicParts);
  }
  return options;
}

/// Names that are taken, with the key of their owner for the message.
class Names {
 public:
  std::string Take(const YamlValue& value, const std::string& name, std::string_view fix) {
    if (!taken_.emplace(name, true).second) {
      value.Fail(fmt::format("named otherwise than '{}', which is taken", name), fix);
    }
    return name;
  }

 private:
  std::map<std::string, bool> taken_;
};

std::string RecordingName(const YamlValue& value, const std::string& up, Names& names) {
  const auto given = value.Find("name");
  if (!given) {
    return names.Take(
        value.At("up", "a SOURCE"), SafeNameOf(up), "add 'name: NAME' to one of the recordings");
  }
  const std::string name = given->Text();
  if (!IsSafeName(name)) {
    given->Fail(fmt::format("letters, digits, '.', '_' and single '-' inside, at most {} of them",
                            kMaxNameBytes),
                "it becomes the name of files");
  }
  return names.Take(*given, name, "give another name");
}

Recording ReadRecording(const YamlValue& value, const fs::path& folder, Names& names) {
  value.AllowOnly(
      {"name", "rig", "up", "stamps", "odometry", "gyro", "forward", "priority", "options"});
  Recording recording;
  recording.rig = ExistingPath(value.At("rig", "'rig: RIG.yaml'"), folder);
  recording.up = Source(value.At("up", "'up: SOURCE', the upward camera"), folder);
  recording.name = RecordingName(value, recording.up, names);
  const auto optional_path = [&](std::string_view key) {
    const auto found = value.Find(key);
    return found ? ExistingPath(*found, folder) : std::string();
  };
  recording.stamps = optional_path("stamps");
  recording.odometry = optional_path("odometry");
  recording.gyro = optional_path("gyro");
  if (const auto forward = value.Find("forward")) recording.forward = Source(*forward, folder);
  if (const auto priority = value.Find("priority")) {
    recording.priority = priority->WholeNumber(-kMaxPriority, kMaxPriority);
  }
  if (const auto options = value.Find("options")) recording.options = Options(*options, false);
  return recording;
}

void ReadMembers(const YamlValue& root, Manifest& manifest) {
  Names names;
  const auto recordings = root.Find("recordings");
  if (recordings) {
    for (const YamlValue& item : recordings->Items()) {
      manifest.recordings.push_back(ReadRecording(item, manifest.folder, names));
    }
  }
  if (const auto maps = root.Find("maps")) {
    for (const YamlValue& item : maps->Items()) {
      const std::string file = MapName(item, ExistingPath(item, manifest.folder));
      manifest.maps.push_back({names.Take(item, SafeNameOf(file), "rename the file"), file});
    }
  }
  if (manifest.recordings.size() + manifest.maps.size() >= 2) return;
  const std::string_view at_least = "at least two recordings or maps together";
  if (recordings) recordings->Fail(at_least, "for one recording, run 'ceilmap map'");
  (void)root.At("recordings", "a list of them");
}

/// The map of the site must not replace what goes into it.
void CheckOutput(const YamlValue& value, const Manifest& manifest) {
  std::error_code ignored;
  const auto real = [&](const std::string& file) {
    return fs::weakly_canonical(manifest.folder / file, ignored);
  };
  for (const ExistingMap& map : manifest.maps) {
    if (real(map.file) == real(manifest.output)) {
      value.Fail("another file than those in 'maps'", "name a new file");
    }
  }
  const fs::path parent = real(manifest.output).parent_path();
  if (!fs::is_directory(parent, ignored)) {
    value.Fail("in a folder that exists", "create it, or choose another");
  }
  if (parent == real(manifest.work) ||
      parent == real((fs::path(manifest.work) / "maps").string())) {
    value.Fail("outside of the folder 'work'", "choose another folder for one of them");
  }
}

}  // namespace

Manifest ParseManifest(const std::string& text, const fs::path& file) {
  const YamlValue root = YamlValue::Parse(text, file, kWhat);
  root.AllowOnly({"output", "work", "recordings", "maps", "options", "control_points", "crs"});
  Manifest manifest;
  manifest.folder = fs::absolute(file).lexically_normal().parent_path();
  const YamlValue output = root.At("output", "'output: site.gpkg'");
  manifest.output = MapName(output, Path(output));
  const auto work = root.Find("work");
  manifest.work =
      work ? Path(*work) : fs::path(manifest.output).replace_extension(".work").string();
  if (const auto options = root.Find("options")) manifest.options = ReadOptions(*options);
  ReadMembers(root, manifest);
  if (const auto points = root.Find("control_points")) {
    manifest.control_points = ExistingPath(*points, manifest.folder);
  }
  if (const auto crs = root.Find("crs")) {
    manifest.crs = Line(*crs);
    if (manifest.control_points.empty()) {
      crs->Fail("beside 'control_points'", "add 'control_points: points.csv'");
    }
  }
  CheckOutput(output, manifest);
  return manifest;
}

Manifest ReadManifest(const fs::path& file) {
  return ParseManifest(ReadSettingsText(file, kWhat), file);
}

}  // namespace ceilmap::site
