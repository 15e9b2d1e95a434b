// `calibrate check` through the real executable, on a simulated drive of a rig that is known.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using support::TestFolder;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

constexpr const char* kScene = R"(seed: 5
axle_behind_mast_m: 0.12
room: {length_m: 8, width_m: 7, height_m: 2.5}
ceiling: {kind: tiles, lamp_every_x: 5, lamp_every_y: 4, vents_per_100m2: 4}
camera:
  width_px: 320
  height_px: 240
  focal_px: 150
  distortion_model: equidistant
  distortion: [0.02, -0.01, 0, 0]
  mount_x_m: 0.03
  mount_yaw_deg: 4
  mount_pitch_deg: 3
  readout_time_s: 0.02
path: {kind: waypoints, waypoints_m: [3, 2.5, 5, 2.5, 5, 4], speed_m_s: 0.8, frame_rate_hz: 8}
)";

/// A drive that all tests share: rendered once.
class CalibrateCheckTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TestFolder;
    folder_->Write("scene.yaml", kScene);
    const support::ProcessResult made =
        support::RunCeilmap({"simulate", "scene.yaml", "-o", "drive"}, folder_->Path().string());
    ASSERT_EQ(made.exit_code, 0) << made.err;
    rig_ = ReadAll(*folder_ / "drive/rig.yaml");
    // The rotation is given once, by the quaternion.
    rig_ = std::regex_replace(rig_, std::regex("\n *matrix: [^\n]*"), "");
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static std::string Changed(const std::string& pattern, const std::string& value) {
    const std::string changed = std::regex_replace(rig_, std::regex(pattern), value);
    EXPECT_NE(changed, rig_) << pattern;
    return changed;
  }
  static support::ProcessResult Check(const std::string& rig,
                                      const std::vector<std::string>& more = {}) {
    folder_->Write("rig.yaml", rig);
    std::vector<std::string> arguments{"calibrate",
                                       "check",
                                       "--rig=rig.yaml",
                                       "--up=drive/up.mp4",
                                       "--stamps=drive/frames.csv",
                                       "--summary=s.json",
                                       "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return support::RunCeilmap(arguments, folder_->Path().string());
  }
  static std::vector<std::string> Complaints() {
    return nlohmann::json::parse(ReadAll(*folder_ / "s.json"))["quality"]["complaints"];
  }

  static TestFolder* folder_;
  static std::string rig_;
};

TestFolder* CalibrateCheckTest::folder_ = nullptr;
std::string CalibrateCheckTest::rig_;

TEST_F(CalibrateCheckTest, ARightRigHasNoComplaints) {
  const support::ProcessResult result = Check(rig_, {"--odometry=drive/truth.tum"});
  EXPECT_EQ(result.exit_code, 0) << result.err << result.out;
  EXPECT_THAT(Complaints(), IsEmpty());
  EXPECT_THAT(result.out, HasSubstr("\nstamps late by"));
  EXPECT_THAT(result.out, testing::Not(HasSubstr("not checked")));
  EXPECT_EQ(result.err, "");
}

TEST_F(CalibrateCheckTest, StatesWhatItCannotCheck) {
  const support::ProcessResult result = Check(rig_);
  EXPECT_EQ(result.exit_code, 0) << result.err << result.out;
  EXPECT_THAT(result.out, HasSubstr("not checked: needs --first-turn or --odometry\n"));
  EXPECT_THAT(result.out, HasSubstr("not checked: needs --odometry or --distance\n"));
  EXPECT_THAT(result.out, HasSubstr("not checked: needs --odometry\n"));
}

TEST_F(CalibrateCheckTest, NamesAWrongFocalLength) {
  const support::ProcessResult result =
      Check(Changed("\\[150, 0, 159.5, 0, 150,", "[154.5, 0, 159.5, 0, 154.5,"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(Complaints(), ElementsAre(StartsWith("the focal length looks 3.")));
  EXPECT_THAT(result.out, HasSubstr("run 'ceilmap calibrate camera'\n"));
  EXPECT_EQ(result.err, "ceilmap: rig.yaml: does not agree with drive/up.mp4\n");
}

TEST_F(CalibrateCheckTest, NamesAWrongHeight) {
  EXPECT_EQ(Check(Changed("\nh: 2.5", "\nh: 2.625"), {"--odometry=drive/truth.tum"}).exit_code, 1);
  EXPECT_THAT(Complaints(), ElementsAre(StartsWith("the ceiling looks 2.")));
  EXPECT_EQ(Check(Changed("\nh: 2.5", "\nh: 2.625")).exit_code, 1);
  EXPECT_THAT(Complaints(), ElementsAre(StartsWith("the camera looks 0.")));
  // From (3, 2.5) to (5, 4), the axle; the mast stands 0.12 m ahead of it.
  EXPECT_EQ(Check(Changed("\nh: 2.5", "\nh: 2.625"), {"--distance=2.492"}).exit_code, 1);
  EXPECT_THAT(Complaints(), ElementsAre(StartsWith("the ceiling looks 2.")));
}

TEST_F(CalibrateCheckTest, NamesAWrongLensModel) {
  std::string rig = Changed("distortion_model: equidistant", "distortion_model: plumb_bob");
  rig = std::regex_replace(rig,
                           std::regex("distortion_coefficients: [^\n]*"),
                           "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}");
  EXPECT_EQ(Check(rig).exit_code, 1);
  EXPECT_THAT(Complaints(),
              testing::Contains(StartsWith("the lens model does not fit (plumb_bob)")));
}

TEST_F(CalibrateCheckTest, NamesAWrongYaw) {
  EXPECT_EQ(Check(Changed("rotation_xyzw: [^\n]*", "rotation_xyzw: [0, 0.026177, 0, 0.999657]"))
                .exit_code,
            1);
  EXPECT_THAT(Complaints(), testing::Contains(HasSubstr(", rotated by a quarter turn (")));
}

TEST_F(CalibrateCheckTest, NamesAMissingReadout) {
  EXPECT_EQ(Check(Changed("\n *readout_time_s: [^\n]*", "")).exit_code, 1);
  EXPECT_THAT(Complaints(), ElementsAre(StartsWith("the read-out time looks like ")));
}

TEST_F(CalibrateCheckTest, NamesLateStamps) {
  // The wheels' clock is 50 ms behind that of the images.
  std::istringstream truth(ReadAll(*folder_ / "drive/truth.tum"));
  std::string early;
  for (std::string line; std::getline(truth, line);) {
    if (line.empty() || line.front() == '#') continue;
    const std::size_t blank = line.find(' ');
    early += std::to_string(std::stod(line.substr(0, blank)) - 0.05) + line.substr(blank) + "\n";
  }
  folder_->Write("early.tum", early);
  EXPECT_EQ(Check(rig_, {"--odometry=early.tum"}).exit_code, 1);
  EXPECT_THAT(Complaints(), ElementsAre(HasSubstr(" ms too late relative to the odometry: ")));
}

TEST_F(CalibrateCheckTest, NamesMirroredImages) {
  EXPECT_EQ(Check(rig_, {"--first-turn=left"}).exit_code, 0);
  EXPECT_EQ(Check(rig_, {"--first-turn=right"}).exit_code, 1);
  EXPECT_THAT(Complaints(), ElementsAre(StartsWith("the images are mirrored: ")));
}

TEST_F(CalibrateCheckTest, StatesThatTheOdometryIsOfAnotherTime) {
  folder_->Write("other.tum",
                 "5 0 0 0 0 0 0 1\n6 1 0 0 0 0 0 1\n7 2 0 0 0 0 0 1\n8 3 0 0 0 0 0 1\n"
                 "9 4 0 0 0 0 0 1\n");
  const support::ProcessResult result = Check(rig_, {"--odometry=other.tum"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out,
              HasSubstr("not checked: the odometry does not cover the drive, or it turns too "
                        "little\n"));
}

TEST_F(CalibrateCheckTest, NamesAWrongSize) {
  const support::ProcessResult result = Check(Changed("image_width: 320", "image_width: 360"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(Complaints(),
              ElementsAre("the images have 320x240 px, camera 'up' of the rig 360x240: use the rig "
                          "of this camera, record in that size, or run 'ceilmap calibrate camera' "
                          "on images of this size"));
}

TEST_F(CalibrateCheckTest, BadInput) {
  EXPECT_EQ(Check(rig_, {"--distance=-1"}).err, "ceilmap: --distance -1: must be > 0, in metres\n");
  EXPECT_EQ(Check(rig_, {"--seconds=0"}).err, "ceilmap: --seconds 0: must be > 0\n");
  const support::ProcessResult shortened = Check(rig_, {"--seconds=1.5"});
  EXPECT_EQ(shortened.exit_code, 2);
  EXPECT_EQ(shortened.err,
            "ceilmap: drive/up.mp4: the robot turns by 0 deg only, must be at least 45; drive "
            "straight ahead, turn, and drive straight ahead again\n");
}

}  // namespace
}  // namespace ceilmap::integration
