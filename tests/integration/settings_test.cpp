// `ceilmap settings`, and `--settings` of the commands.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "app/commands/settings_options.hpp"
#include "tests/integration/recordings.hpp"

namespace ceilmap::integration {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::IsEmpty;

const fs::path kSource = CEILMAP_SOURCE_DIR;

TEST(SettingsCommand, TheTableInTheRepositoryIsUpToDate) {
  const support::TestFolder folder;
  const support::ProcessResult result = support::RunCeilmap({"settings"}, folder.Path().string());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out, support::ReadAll(kSource / "app/SETTINGS.md"))
      << "run: ceilmap settings > app/SETTINGS.md";
}

TEST(SettingsCommand, TheFileIsReadBackByEachCommand) {
  const support::TestFolder folder;
  const support::ProcessResult result =
      support::RunCeilmap({"settings", "--format=yaml"}, folder.Path().string());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  commands::CommandSettings params;
  const Settings settings = commands::Describe(params);
  const std::string before = FormatSettingsFile(settings);
  EXPECT_EQ(result.out, before);
  settings.Parse(result.out, "settings.yaml");
  EXPECT_EQ(FormatSettingsFile(settings), before);
}

// A field of a struct, as its header declares it.
struct Field {
  std::string type;
  std::string name;
};

std::string WithoutComments(const fs::path& file) {
  const std::string text = support::ReadAll(file);
  std::string code;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t comment = std::min(text.find("//", at), text.size());
    code.append(text, at, comment - at);
    at = std::min(text.find('\n', comment), text.size());
  }
  return code;
}

// The data members of the structs whose names end in Params.
void AddFields(const std::string& text, std::map<std::string, std::vector<Field>>& structs) {
  if (text.find("Params") == std::string::npos) return;  // most files, and expressions take long
  static const std::regex begin(R"(\bstruct\s+(\w*Params)\s*\{)");
  static const std::regex declaration(R"((\S.*\S)\s+(\w+)\s*$)");
  for (std::sregex_iterator match(text.begin(), text.end(), begin), end; match != end; ++match) {
    std::vector<Field>& fields = structs[(*match)[1]];
    // Statements at the depth of the struct, without what stands in inner braces.
    std::string statement;
    int depth = 1;
    for (auto at = static_cast<std::size_t>(match->position() + match->length()); depth > 0; ++at) {
      const char c = text[at];
      if (c == '}') --depth;
      if (depth == 1 && c != '}') statement += c;
      if (c == '{') ++depth;
      if (depth != 1 || c != ';') continue;
      statement = statement.substr(0, statement.find_first_of("={;"));
      std::smatch field;
      const bool is_field = statement.find('(') == std::string::npos &&
                            statement.find("static ") == std::string::npos;
      if (is_field && std::regex_search(statement, field, declaration)) {
        fields.push_back({field[1], field[2]});
      }
      statement.clear();
    }
  }
}

std::map<std::string, std::vector<Field>> ReadStructs() {
  std::map<std::string, std::vector<Field>> structs;
  for (const char* top : {"app", "calib", "compensation", "localization", "mapping", "samples"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kSource / top)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".hpp" && extension != ".cpp") continue;
      AddFields(WithoutComments(entry.path()), structs);
    }
  }
  return structs;
}

// Read once.
const std::map<std::string, std::vector<Field>>& StructsOfTheRepository() {
  static const auto structs = ReadStructs();
  return structs;
}

TEST(SettingsTable, ParametersAreFew) {
  std::size_t fields = 0;
  for (const auto& [name, members] : StructsOfTheRepository()) fields += members.size();
  EXPECT_GT(fields, 100U);  // the headers are understood
  EXPECT_LE(fields, 170U) << "make a constant of each parameter that no experiment varies";
}

// Fields without a row, and why.
const std::map<std::string, std::string> kExceptions = {
    {"OdometryParams.first_keyframe_id", "set by the mapper"},
    {"MapperParams.first_keyframe_id", "set with --append"},
    {"MapperParams.origin", "--origin"},
    {"LoopCloserParams.noise", "that of the odometry"},
    {"LoopCloserParams.heading", "that of the odometry"},
    {"LoopCloserParams.registration", "that of the odometry"},
    {"RegistrarParams.estimate_scale", "depends on the rig"},
    {"RegistrarParams.mask", "depends on the camera"},
    {"RegistrarParams.camera", "depends on the camera"},
    {"RegistrarParams.local_features", "depends on the use"},
    {"RegistrarParams.same_recording", "depends on the use"},
    {"MosaicParams.resolution", "--resolution"},
    {"MosaicParams.view_mask", "depends on the camera"},
    {"LocalizerParams.start", "--start"},
    {"SensorsParams.measure_tilt", "--tilt"},
    {"SensorsParams.heading_model", "--heading-model"},
    {"TiltEstimatorParams.method", "--tilt"},
    {"CompassParams.method", "--method"},
    {"Labrosse2006Params.skip", "--skip"},
    {"LearnParams.grid", "--grid"},
    {"LearnParams.depth_m", "--depth"},
    {"LearnParams.camera_ahead_of_axle_m", "depends on the rig"},
    {"ColourClassParams.seed", "--seed"},
    {"ColourCompassParams.camera_ahead_of_axle_m", "depends on the rig"},
};

class SettingsRows : public testing::Test {
 protected:
  // Checks that each field of a struct has a row, or a reason why it has none.
  void ExpectRows(const std::string& type, const std::string& prefix) {
    ASSERT_TRUE(structs_.contains(type)) << type;
    for (const Field& field : structs_.at(type)) {
      if (kExceptions.contains(type + "." + field.name)) continue;
      const std::string key = prefix + "." + field.name;
      const std::string inner = field.type.substr(field.type.rfind(':') + 1);
      if (structs_.contains(inner)) {
        ExpectRows(inner, key);
      } else if (inner == "EdgeNoise") {
        EXPECT_TRUE(keys_.contains(key + ".systematic_px")) << key;
        EXPECT_TRUE(keys_.contains(key + ".systematic_rad")) << key;
      } else {
        EXPECT_TRUE(keys_.contains(key)) << type << "::" << field.name << " has no row " << key;
      }
    }
  }

  const std::map<std::string, std::vector<Field>>& structs_ = StructsOfTheRepository();
  commands::CommandSettings params_;
  std::set<std::string> keys_ = [this] {
    std::set<std::string> keys;
    const Settings settings = commands::Describe(params_);
    for (const Setting& setting : settings.List()) keys.insert(setting.key);
    return keys;
  }();
};

TEST_F(SettingsRows, EachParameterOfTheCommandsHasOne) {
  ExpectRows("MapperParams", "mapping");
  ExpectRows("SensorsParams", "sensors");
  ExpectRows("LocalizerParams", "localization");
  ExpectRows("CompassParams", "compass");
  ExpectRows("LearnParams", "colour_learn");
  ExpectRows("ColourCompassParams", "colour_compass");
}

TEST_F(SettingsRows, ExceptionsAreFieldsStill) {
  for (const auto& [name, reason] : kExceptions) {
    const std::string type = name.substr(0, name.find('.'));
    ASSERT_TRUE(structs_.contains(type)) << type;
    const std::vector<Field>& fields = structs_.at(type);
    EXPECT_TRUE(std::any_of(fields.begin(), fields.end(), [&](const Field& field) {
      return type + "." + field.name == name;
    })) << name;
  }
}

class SettingsOption : public testing::Test {
 protected:
  [[nodiscard]] support::ProcessResult Map(const std::string& settings) const {
    test_.in.Write("s.yaml", settings);
    return test_.Run({"map",
                      "--quiet",
                      "--rig=@rig.yaml",
                      "--up=@run.avi",
                      "--settings=@s.yaml",
                      "--summary=s.json",
                      "-o",
                      "m.gpkg",
                      "--force"});
  }
  [[nodiscard]] nlohmann::json Summary() const {
    return nlohmann::json::parse(support::ReadAll(test_.out / "s.json"));
  }
  void ExpectRefused(const support::ProcessResult& result, const std::string& message) const {
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_THAT(result.err, HasSubstr(message));
    EXPECT_THAT(test_.out.Names(), IsEmpty());
  }

  Recordings test_;
};

TEST_F(SettingsOption, ValuesTakeEffectAndStandInTheSummary) {
  const auto keyframes = [this] { return Summary()["quality"]["keyframes"].get<int>(); };
  ASSERT_EQ(Map("mapping: {odometry: {min_overlap: 0.7}}\n").err, "");
  const int usual = keyframes();
  ASSERT_EQ(Map("mapping: {odometry: {min_overlap: 0.9}}\n").err, "");
  EXPECT_GT(keyframes(), usual);
  const nlohmann::json settings = Summary()["settings"];
  EXPECT_EQ(settings["mapping"]["odometry"]["min_overlap"], 0.9);
  EXPECT_EQ(settings["mapping"]["odometry"]["recent_keyframes"], 4);
  EXPECT_EQ(settings["sensors"]["max_offset_s"], 0.05);
  EXPECT_FALSE(settings.contains("localization"));
}

TEST_F(SettingsOption, TheSummaryIsASettingsFile) {
  ASSERT_EQ(Map("mapping: {mosaic: {sharpness_power: 3}}\n").err, "");
  ASSERT_EQ(Map(Summary()["settings"].dump(1)).err, "");
  EXPECT_EQ(Summary()["settings"]["mapping"]["mosaic"]["sharpness_power"], 3);
}

TEST_F(SettingsOption, WhatCannotBeUsedIsRefused) {
  ExpectRefused(Map("mapping:\n  odometry:\n    recent_keyframe: 3\n"),
                "s.yaml:3: unknown key 'mapping.odometry.recent_keyframe'; did you mean "
                "'mapping.odometry.recent_keyframes'?");
  ExpectRefused(Map("mapping: {odometry: {min_overlap: 1}}\n"),
                "s.yaml:1: mapping.odometry.min_overlap = 1, must be in (0, 1); correct the value");
  ExpectRefused(Map("mapping: {odometry: {min_overlap: much}}\n"),
                "mapping.odometry.min_overlap = much, must be a finite number");
  ExpectRefused(Map("no settings\n"), "must be a map of keys");
  ExpectRefused(Map("localization: {tilt_checks: -1}\n"),
                "localization.tilt_checks = -1, must be >= 0");
}

TEST_F(SettingsOption, EachCommandChecksTheFileFirst) {
  test_.in.Write("bad.yaml", "nothing: 1\n");
  const std::string message = "unknown key 'nothing'";
  const std::vector<std::vector<std::string>> commands = {
      {"localize", "m.gpkg", "--rig=r.yaml", "--up=u", "-o", "t.tum"},
      {"heading", "--ring=1,1,1,2", "--omni=o", "-o", "h.csv"},
      {"compass", "learn", "--rig=r", "--forward=f", "--poses=p.tum", "-o", "m"},
      {"compass", "query", "m", "--rig=r", "--forward=f", "-o", "h.csv"},
      {"compass", "update", "m", "--rig=r", "--forward=f", "--poses=p.tum"},
  };
  for (std::vector<std::string> command : commands) {
    command.emplace_back("--settings=@bad.yaml");
    ExpectRefused(test_.Run(command), message);
  }
}

}  // namespace
}  // namespace ceilmap::integration
