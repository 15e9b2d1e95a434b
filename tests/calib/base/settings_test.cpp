#include "calib/base/settings.hpp"

#include <filesystem>
#include <fstream>

#include "calib/base/error.hpp"

namespace ceilmap {
namespace {

enum class Colour { kRed, kGreen };

struct Things {
  double width_m = 0.5;
  int count = 4;
  bool shiny = true;
  Colour colour = Colour::kGreen;
  double inner_height_m = 1e-5;

  [[nodiscard]] Settings Describe() {
    Settings settings;
    const Settings box = settings.In("box");
    box.Add("width_m", width_m, "m", SettingRange::Open(0, 1), "Width of the box.");
    box.Add("count", count, "", SettingRange::AtLeast(1), "Number of boxes.");
    box.Add("shiny", shiny, "Whether the box reflects light.");
    box.AddChoice(
        "colour", colour, {{"red", Colour::kRed}, {"green", Colour::kGreen}}, "Colour of the box.");
    settings.In("box").In("inner").Add(
        "height_m", inner_height_m, "m", SettingRange::Above(0), "Height of the inner box.");
    return settings;
  }
};

std::string ErrorOf(const std::string& text) {
  Things things;
  try {
    things.Describe().Parse(text, "s.yaml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Settings, GivenValuesTakeEffectAndOthersStay) {
  Things things;
  things.Describe().Parse("box:\n  count: 7\n  colour: red\n  inner: {height_m: 2}\n", "s.yaml");
  EXPECT_EQ(things.count, 7);
  EXPECT_EQ(things.colour, Colour::kRed);
  EXPECT_EQ(things.inner_height_m, 2);
  EXPECT_EQ(things.width_m, 0.5);
  EXPECT_TRUE(things.shiny);
  things.Describe().Parse("box: {shiny: false, width_m: 0.25}\n", "s.yaml");
  EXPECT_FALSE(things.shiny);
  EXPECT_EQ(things.width_m, 0.25);
}

TEST(Settings, UnknownKeysNameTheMostSimilar) {
  EXPECT_EQ(ErrorOf("box:\n  cuont: 7\n"),
            "s.yaml:2: unknown key 'box.cuont'; did you mean 'box.count'?");
  EXPECT_EQ(ErrorOf("boxes:\n  count: 7\n"), "s.yaml:1: unknown key 'boxes'; did you mean 'box'?");
  EXPECT_EQ(ErrorOf("height_m: 2\n"),
            "s.yaml:1: unknown key 'height_m'; did you mean 'box.inner.height_m'?");
}

TEST(Settings, ValuesOutOfRangeAreRefused) {
  EXPECT_EQ(ErrorOf("box: {width_m: 1}\n"),
            "s.yaml:1: box.width_m = 1, must be in (0, 1); correct the value");
  EXPECT_EQ(ErrorOf("box: {count: 0}\n"),
            "s.yaml:1: box.count = 0, must be >= 1; correct the value");
  EXPECT_EQ(ErrorOf("box:\n  inner:\n    height_m: 0\n"),
            "s.yaml:3: box.inner.height_m = 0, must be > 0; correct the value");
  EXPECT_EQ(ErrorOf("box: {colour: blue}\n"),
            "s.yaml:1: box.colour = blue, must be red or green; correct the value");
}

TEST(Settings, WrongTypesAreRefused) {
  EXPECT_EQ(ErrorOf("box: {width_m: wide}\n"),
            "s.yaml:1: box.width_m = wide, must be a finite number; write it plainly, e.g. 0.45, "
            "without quotes or unit");
  EXPECT_NE(ErrorOf("box: {count: 1.5}\n"), "");
  EXPECT_EQ(ErrorOf("box: {shiny: 1}\n"),
            "s.yaml:1: box.shiny = 1, must be false or true; correct the value");
  EXPECT_NE(ErrorOf("box: {width_m: {a: 1}}\n"), "");
  EXPECT_EQ(ErrorOf("box: 3\n"),
            "s.yaml:1: box = 3, must be a map of keys; write 'key: value' lines below it");
  EXPECT_EQ(ErrorOf("box: {count: 1, count: 2}\n"),
            "s.yaml:1: box.count = 2, must be given once; remove one of the two");
  EXPECT_EQ(ErrorOf("- 1\n"),
            "s.yaml:1: [1] stands alone, must be a map of keys; give a settings file");
}

TEST(Settings, AMissingFileIsRefused) {
  Things things;
  EXPECT_THROW(things.Describe().Load("/nowhere/settings.yaml"), InputError);
}

TEST(Settings, TheFileIsReadBack) {
  Things things;
  things.width_m = 0.1 + 0.2;
  things.colour = Colour::kRed;
  const std::string text = FormatSettingsFile(things.Describe());
  EXPECT_EQ(text,
            "box:\n"
            "  width_m: 0.30000000000000004  # m, in (0, 1)\n"
            "  count: 4  # >= 1\n"
            "  shiny: true  # false or true\n"
            "  colour: red  # red or green\n"
            "  inner:\n"
            "    height_m: 1e-05  # m, > 0\n");
  Things others;
  others.Describe().Parse(text, "s.yaml");
  EXPECT_EQ(others.width_m, things.width_m);
  EXPECT_EQ(others.colour, Colour::kRed);
  EXPECT_EQ(others.inner_height_m, 1e-5);
}

TEST(Settings, TheTableHasARowForEach) {
  Things things;
  const std::string table = FormatSettingsTable(things.Describe());
  EXPECT_NE(table.find("| `box.width_m` | m | in (0, 1) | 0.5 | Width of the box. |\n"),
            std::string::npos);
  EXPECT_NE(table.find("| `box.colour` |  | red or green | green | Colour of the box. |\n"),
            std::string::npos);
}

}  // namespace
}  // namespace ceilmap
