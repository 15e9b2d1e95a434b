// `calibrate mirror` through the real executable, on a simulated mirror whose place is known.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "calib/rig.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using support::TestFolder;

const std::string kScene = R"(seed: 2
room: {length_m: 6, width_m: 5, height_m: 2.6, wall_brightness: 0.32, wall_posters_per_100m2: 45, floor_contrast: 0.2}
ceiling: {kind: tiles}
camera: {width_px: 32, height_px: 32, focal_px: 30}
omni: {width_px: 280, height_px: 280, focal_px: 290, centre_offset_px: [4.3, -2.6]}
path: {kind: tum, tum_file: turn.tum}
)";

class CalibrateMirrorTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TestFolder;
    std::string turn;
    for (int i = 0; i < 20; ++i) {
      const double yaw = i * std::numbers::pi / 10;
      turn += fmt::format(
          "{} 2.6 2.3 0 0 0 {:.9f} {:.9f}\n", 100 + i, std::sin(yaw / 2), std::cos(yaw / 2));
    }
    folder_->Write("turn.tum", turn);
    folder_->Write("scene.yaml", kScene);
    const support::ProcessResult made = Run({"simulate", "scene.yaml", "-o", "turn", "--pictures"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static support::ProcessResult Run(const std::vector<std::string>& arguments) {
    return support::RunCeilmap(arguments, folder_->Path().string());
  }
  static support::ProcessResult Calibrate(const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"calibrate", "mirror"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  static void ExpectFault(const support::ProcessResult& result, const std::string& text) {
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, "ceilmap: " + text + "\n");
  }

  static TestFolder* folder_;
};

TestFolder* CalibrateMirrorTest::folder_ = nullptr;

TEST_F(CalibrateMirrorTest, FindsTheMirrorOfATurningRobot) {
  const support::ProcessResult result = Calibrate({"--omni=turn/omni",
                                                   "--rig=turn/rig.yaml",
                                                   "--report=report",
                                                   "--panorama=panorama.png",
                                                   "-o",
                                                   "new.yaml"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const calib::Rig truth = calib::ReadRig(*folder_ / "turn/rig.yaml");
  const calib::Rig rig = calib::ReadRig(*folder_ / "new.yaml");
  EXPECT_NEAR(rig.omni->camera.cx, truth.omni->camera.cx, 0.3);
  EXPECT_NEAR(rig.omni->camera.cy, truth.omni->camera.cy, 0.3);
  EXPECT_NEAR(rig.omni->mirror->rim_radius_px, truth.omni->mirror->rim_radius_px, 0.3);
  EXPECT_NEAR(rig.omni->camera.fx, truth.omni->camera.fx, 0.6);
  EXPECT_TRUE(rig.up);
  for (const char* file : {"panorama.png", "report/mirror.png", "report/tables.md"}) {
    EXPECT_TRUE(std::filesystem::exists(*folder_ / file)) << file;
  }
}

TEST_F(CalibrateMirrorTest, ARigWithoutAMirrorGetsOne) {
  std::string rig = ReadAll(*folder_ / "turn/rig.yaml");
  rig.resize(rig.find("  omni:"));
  folder_->Write("up.yaml", rig);
  const support::ProcessResult result =
      Calibrate({"--omni=turn/omni", "--rig=up.yaml", "-o", "ring.yaml", "--summary=s.json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const calib::Rig truth = calib::ReadRig(*folder_ / "turn/rig.yaml");
  const calib::Rig found = calib::ReadRig(*folder_ / "ring.yaml");
  ASSERT_TRUE(found.omni && found.omni->mirror_ring);
  EXPECT_NEAR(found.omni->mirror_ring->centre_px.x(), truth.omni->camera.cx, 0.3);
  const auto parameters =
      nlohmann::json::parse(ReadAll(*folder_ / "s.json"))["quality"]["parameters"];
  EXPECT_NEAR(parameters["outer_radius_px"]["value"], truth.omni->mirror->rim_radius_px, 0.3);
}

TEST_F(CalibrateMirrorTest, ByHand) {
  const support::ProcessResult result =
      Calibrate({"--omni=turn/omni/000000.png", "--ring=140,140,30,120", "--panorama=by-hand.png"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(std::filesystem::exists(*folder_ / "by-hand.png"));
}

TEST_F(CalibrateMirrorTest, UnusableRecordings) {
  std::filesystem::create_directory(*folder_ / "still");
  for (const char* name : {"still/0.png", "still/1.png", "still/2.png"}) {
    folder_->Write(name, ReadAll(*folder_ / "turn/omni/000000.png"));
  }
  ExpectFault(Calibrate({"--omni=still"}),
              "still: nothing moves in the mirror; record it while the robot turns, in a lit room "
              "with things in it");
  ExpectFault(Calibrate({"--omni=turn/up/000000.png"}),
              "turn/up/000000.png: no mirror with a round rim was found; light the room, or give "
              "its position: --ring U,V,INNER,OUTER");
  ExpectFault(
      Calibrate({"--omni=turn/omni", "-o", "x.yaml"}),
      "calibrate mirror: -o writes a rig with the mirror added; give the existing rig by --rig");
}

}  // namespace
}  // namespace ceilmap::integration
