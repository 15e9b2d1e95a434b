// `calibrate rig` through the real executable, on simulated recordings of a rig that is known.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/rig.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using support::TestFolder;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;
constexpr double kAxle = 0.12;
constexpr double kLength = 1.5;

/// @param camera  More lines of the upward camera.
std::string Scene(const std::string& tum, const std::string& camera = "") {
  return R"(seed: 5
axle_behind_mast_m: 0.12
room: {length_m: 8, width_m: 7, height_m: 2.5, wall_posters_per_100m2: 60, floor_contrast: 0.12}
ceiling: {kind: tiles, lamp_every_x: 5, lamp_every_y: 4, vents_per_100m2: 4}
camera:
  width_px: 320
  height_px: 240
  focal_px: 230
  distortion: [-0.08, 0, 0, 0, 0]
  mount_y_m: 0.02
  mount_yaw_deg: 3
  mount_pitch_deg: 1
  mount_roll_deg: -0.6
)" + camera +
         R"(forward:
  width_px: 320
  height_px: 240
  focal_px: 277
  mount_height_m: 0.45
  mount_yaw_deg: 2
  mount_pitch_deg: 4
  mount_roll_deg: -1
wheels:
  scale_error_ratio: 0.02
  track_width_error_ratio: -0.03
  translation_noise_per_sqrt_m: 0
  yaw_noise_deg_per_sqrt_m: 0
gyro: {bias_deg_s: 0.4}
path: {kind: tum, tum_file: )" +
         tum + "}\n";
}

/// A line of the robot's axle at a place, heading as given.
std::string TumLine(int index, double x, double y, double yaw) {
  return fmt::format("{:.3f} {:.9f} {:.9f} 0 0 0 {:.9f} {:.9f}\n",
                     100 + 0.2 * index,
                     x + kAxle * std::cos(yaw),
                     y + kAxle * std::sin(yaw),
                     std::sin(yaw / 2),
                     std::cos(yaw / 2));
}

/// Recordings that all tests share: rendered once.
class CalibrateRigTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TestFolder;
    std::string spin;
    std::string drift;
    for (int i = 0; i <= 40; ++i) {
      spin += TumLine(i, 4, 3.5, 9 * kRadPerDeg * i);
      drift += TumLine(i, 4 + 0.005 * i, 3.5, 9 * kRadPerDeg * i);
    }
    std::string straight;
    std::string curve;
    for (int i = 0; i <= 20; ++i) {
      const double s = kLength * i / 20;
      straight += TumLine(i, 3 + s * std::cos(0.3), 3.2 + s * std::sin(0.3), 0.3);
      curve += TumLine(i, 3 + s, 3.2, 0.2 * kRadPerDeg * i);
    }
    Render("spin", spin);
    Render("drift", drift);
    Render("straight", straight);
    Render("curve", curve);
    Render("rolling-spin", spin, "  readout_time_s: 0.03\n");
    Render("rolling-straight", straight, "  readout_time_s: 0.03\n");
    const std::string rig = ReadAll(*folder_ / "spin/rig.yaml");
    // With a forward camera that points straight ahead, by the initial rig.
    std::string ahead = "d: 0.45\n" + rig.substr(rig.find("cameras:"));
    for (std::size_t at = 0; (at = ahead.find("      matrix:", at)) != std::string::npos;) {
      ahead.erase(at, ahead.find('\n', at) + 1 - at);
    }
    const std::size_t turn = ahead.find("rotation_xyzw:", ahead.find("  forward:"));
    ahead.replace(turn, ahead.find('\n', turn) - turn, "rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]");
    folder_->Write("ahead.yaml", ahead);
    // The intrinsics, and that the camera is 0.4 m above the floor and points up.
    std::string rough = "robot: test\nd: 0.45\n" + rig.substr(rig.find("cameras:"));
    rough.resize(rough.find("      translation:"));  // and no other camera
    rough +=
        "      translation: [0, 0, 0.4]\n"
        "      rotation_xyzw: [0, 0, 0.707106781, 0.707106781]\n";
    folder_->Write("rough.yaml", rough);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static void Render(const std::string& name,
                     const std::string& poses,
                     const std::string& camera = "") {
    folder_->Write(name + ".tum", poses);
    folder_->Write(name + ".yaml", Scene(name + ".tum", camera));
    const support::ProcessResult made = Run({"simulate", name + ".yaml", "-o", name, "--pictures"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static support::ProcessResult Run(const std::vector<std::string>& arguments) {
    return support::RunCeilmap(arguments, folder_->Path().string());
  }
  static support::ProcessResult Calibrate(const std::string& spin,
                                          const std::string& straight,
                                          const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"calibrate",
                                       "rig",
                                       "--spin=" + spin,
                                       "--straight=" + straight,
                                       "--summary=s.json",
                                       "-o",
                                       "new.yaml",
                                       "--force"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Run(arguments);
  }
  static nlohmann::json Parameters() {
    return nlohmann::json::parse(ReadAll(*folder_ / "s.json"))["quality"]["parameters"];
  }
  /// Within three deviations, and within what a robot needs.
  static void ExpectTruth(const std::string& name, double truth, double within) {
    const nlohmann::json found = Parameters()[name];
    const double error = found["value"].get<double>() - truth;
    EXPECT_LT(std::abs(error), within) << name;
    EXPECT_LT(std::abs(error), 3 * found["sigma"].get<double>()) << name;
  }
  static void ExpectMount() {
    ExpectTruth("a_m", kAxle, 0.002);
    ExpectTruth("camera_y_m", 0.02, 0.002);
    ExpectTruth("yaw_deg", 93, 0.1);
    ExpectTruth("pitch_deg", 1, 0.05);
    ExpectTruth("roll_deg", -0.6, 0.05);
  }
  static void ExpectFault(const support::ProcessResult& result, const std::string& text) {
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, "ceilmap: " + text + "\n");
  }

  static TestFolder* folder_;
};

TestFolder* CalibrateRigTest::folder_ = nullptr;

TEST_F(CalibrateRigTest, FindsTheMountUnderACeilingOfKnownHeight) {
  const support::ProcessResult result =
      Calibrate("spin/up", "straight/up", {"--rig=rough.yaml", "--ceiling-height=2.5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("camera y"));
  ExpectMount();
  const calib::Rig rig = calib::ReadRig(*folder_ / "new.yaml");
  const calib::Rig truth = calib::ReadRig(*folder_ / "spin/rig.yaml");
  EXPECT_NEAR(rig.axle_behind_mast_m, kAxle, 0.002);
  EXPECT_DOUBLE_EQ(rig.ceiling_height_m, 2.5);
  EXPECT_DOUBLE_EQ(*rig.forward_height_m, 0.45);
  EXPECT_EQ(rig.robot, "test");
  EXPECT_LT((rig.up->T_base_cam.translation() - truth.up->T_base_cam.translation()).norm(), 0.002);
  const Eigen::AngleAxisd off(rig.up->T_base_cam.linear().transpose() *
                              truth.up->T_base_cam.linear());
  EXPECT_LT(off.angle() / kRadPerDeg, 0.1);
}

TEST_F(CalibrateRigTest, AMeasuredDistanceGivesTheCeilingsHeight) {
  support::ProcessResult result = Calibrate(
      "spin/up", "straight/up", {"--rig=rough.yaml", "--distance=1.5", "--report=report"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ExpectMount();
  ExpectTruth("h_m", 2.5, 0.003 * 2.1);
  ExpectTruth("distance_m", 2.1, 0.003 * 2.1);
  for (const char* file : {"spin-before.png", "spin-after.png", "tables.md", "figures/spin.gp"}) {
    EXPECT_TRUE(std::filesystem::exists(*folder_ / "report" / file)) << file;
  }
  result = Run({"map",
                "--rig=new.yaml",
                "--up=straight/up",
                "--stamps=straight/frames.csv",
                "-o",
                "map.gpkg"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST_F(CalibrateRigTest, WithBothTheCamerasHeightComesOutToo) {
  const support::ProcessResult result = Calibrate(
      "spin/up", "straight/up", {"--rig=rough.yaml", "--distance=1.5", "--ceiling-height=2.5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  ExpectTruth("camera_z_m", 0.4, 0.003 * 2.1);
}

TEST_F(CalibrateRigTest, TheReadoutTimeIsWrittenToTheRig) {
  const support::ProcessResult result =
      Calibrate("rolling-spin/up",
                "rolling-straight/up",
                {"--rig=rough.yaml",
                 "--ceiling-height=2.5",
                 "--spin-stamps=rolling-spin/frames.csv",
                 "--straight-stamps=rolling-straight/frames.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  ExpectMount();
  ExpectTruth("readout_ms", 30, 1);
  EXPECT_NEAR(calib::ReadRig(*folder_ / "new.yaml").up->readout_time_s, 0.03, 0.001);
  EXPECT_THAT(ReadAll(*folder_ / "new.yaml"), HasSubstr("\n#   up: read-out = 0.0"));
}

TEST_F(CalibrateRigTest, WithoutTimesTheReadoutTimeIsNotMeasured) {
  const support::ProcessResult result = Calibrate(
      "rolling-spin/up", "rolling-straight/up", {"--rig=rough.yaml", "--ceiling-height=2.5"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err,
            "ceilmap: warning: rolling-spin/up: the rows of an image are exposed one after the "
            "other (rolling shutter), but without times of the images readout_time_s cannot be "
            "measured; give --spin-stamps and --straight-stamps\n");
  ExpectMount();
  EXPECT_THAT(ReadAll(*folder_ / "new.yaml"), testing::Not(HasSubstr("readout_time_s")));
}

TEST_F(CalibrateRigTest, AReadoutTimeThatSlowMotionDoesNotShowRemains) {
  std::string known = ReadAll(*folder_ / "rough.yaml");
  known += "    readout_time_s: 0.004\n";
  folder_->Write("known.yaml", known);
  const auto write_slow = [](const std::string& name, int frames) {
    std::string stamps = "index,timestamp\n";
    for (int i = 0; i <= frames; ++i) stamps += fmt::format("{},{}\n", i, 20 * i);
    folder_->Write(name, stamps);
  };
  write_slow("slow-spin.csv", 40);
  write_slow("slow-straight.csv", 20);
  const support::ProcessResult result = Calibrate("spin/up",
                                                  "straight/up",
                                                  {"--rig=known.yaml",
                                                   "--ceiling-height=2.5",
                                                   "--spin-stamps=slow-spin.csv",
                                                   "--straight-stamps=slow-straight.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err,
              AllOf(StartsWith("ceilmap: the read-out time of the upward camera is known to "),
                    EndsWith(" ms only and remains 4.0 ms: the robot moves too slowly by the times "
                             "of the images\n")));
  ExpectMount();
  EXPECT_EQ(calib::ReadRig(*folder_ / "new.yaml").up->readout_time_s, 0.004);
}

TEST_F(CalibrateRigTest, WheelsAndGyroAreComparedWithTheCeiling) {
  const std::vector<std::string> known{"--rig=rough.yaml",
                                       "--ceiling-height=2.5",
                                       "--spin-stamps=spin/frames.csv",
                                       "--straight-stamps=straight/frames.csv"};
  const auto calibrate = [&](std::vector<std::string> more) {
    more.insert(more.end(), known.begin(), known.end());
    return Calibrate("spin/up", "straight/up", more);
  };
  support::ProcessResult result = calibrate({"--spin-odometry=spin/odometry.csv",
                                             "--straight-odometry=straight/odometry.csv",
                                             "--spin-gyro=spin/gyro.csv",
                                             "--straight-gyro=straight/gyro.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("gyro bias"));
  ExpectMount();
  ExpectTruth("wheel_scale", 1 / 1.02, 0.005);
  ExpectTruth("turn_scale", 1 / 0.97, 0.005);
  ExpectTruth("gyro_bias_deg_s", 0.4, 0.1);
  const calib::Rig rig = calib::ReadRig(*folder_ / "new.yaml");
  ASSERT_TRUE(rig.wheels);
  EXPECT_NEAR(rig.wheels->scale.value, Parameters()["wheel_scale"]["value"].get<double>(), 1e-5);
  EXPECT_THAT(ReadAll(*folder_ / "new.yaml"), HasSubstr("\n#   wheels: scale = 0.98"));

  result = calibrate({"--spin-gyro=spin/gyro.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(Parameters().contains("wheel_scale"));
  ExpectTruth("gyro_bias_deg_s", 0.4, 0.1);
}

TEST_F(CalibrateRigTest, WheelsThatCannotBeThoseOfTheRecording) {
  std::string late = "timestamp,omega_z\n";
  std::string mirrored = "timestamp,omega_z\n";
  for (int i = 0; i < 200; ++i) {
    late += fmt::format("{:.2f},0.8\n", 500 + 0.05 * i);
    mirrored += fmt::format("{:.2f},{:.6f}\n", 99.5 + 0.05 * i, -45 * kRadPerDeg);
  }
  folder_->Write("late.csv", late);
  folder_->Write("mirrored.csv", mirrored);
  const auto with = [](const std::string& gyro) {
    return Calibrate("spin/up",
                     "straight/up",
                     {"--rig=rough.yaml",
                      "--ceiling-height=2.5",
                      "--spin-stamps=spin/frames.csv",
                      "--straight-stamps=straight/frames.csv",
                      "--spin-gyro=" + gyro});
  };
  ExpectFault(
      with("late.csv"),
      "late.csv: has no samples at the times of the images; do the two use the same clock?");
  const support::ProcessResult result = with("mirrored.csv");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("its yaw has the opposite sign"));
  EXPECT_THAT(Calibrate("spin/up",
                        "straight/up",
                        {"--rig=rough.yaml", "--ceiling-height=2.5", "--spin-gyro=spin/gyro.csv"})
                  .err,
              HasSubstr("wheels and gyro need the times of the images; give --spin-stamps and"));
}

TEST_F(CalibrateRigTest, SpinAndDriveDetermineTheForwardCamera) {
  const support::ProcessResult result = Calibrate("spin/up",
                                                  "straight/up",
                                                  {"--rig=ahead.yaml",
                                                   "--ceiling-height=2.5",
                                                   "--spin-forward=spin/forward",
                                                   "--straight-forward=straight/forward"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  ExpectTruth("forward_yaw_deg", 2, 0.15);
  ExpectTruth("forward_pitch_deg", 4, 0.15);
  ExpectTruth("forward_roll_deg", -1, 0.15);
  const calib::Rig rig = calib::ReadRig(*folder_ / "new.yaml");
  const calib::Rig truth = calib::ReadRig(*folder_ / "spin/rig.yaml");
  const Eigen::AngleAxisd off(rig.forward->T_base_cam.linear().transpose() *
                              truth.forward->T_base_cam.linear());
  EXPECT_LT(off.angle() / kRadPerDeg, 0.2);
  EXPECT_DOUBLE_EQ(rig.forward->T_base_cam.translation().z(), 0.45);
}

// The same cameras, described at twice the size of the recordings.
TEST_F(CalibrateRigTest, TheRigsCamerasAreScaledToTheRecordings) {
  std::string twice = ReadAll(*folder_ / "ahead.yaml");
  const auto replace = [&twice](const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = twice.find(from, at)) != std::string::npos; at += to.size()) {
      twice.replace(at, from.size(), to);
    }
  };
  replace("image_width: 320", "image_width: 640");
  replace("image_height: 240", "image_height: 480");
  replace("[230, 0, 159.5, 0, 230, 119.5,", "[460, 0, 319.5, 0, 460, 239.5,");
  replace("[277, 0, 159.5, 0, 277, 119.5,", "[554, 0, 319.5, 0, 554, 239.5,");
  folder_->Write("twice.yaml", twice);
  const support::ProcessResult result = Calibrate("spin/up",
                                                  "straight/up",
                                                  {"--rig=twice.yaml",
                                                   "--ceiling-height=2.5",
                                                   "--spin-forward=spin/forward",
                                                   "--straight-forward=straight/forward"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err,
            "ceilmap: the rig's camera 'up' has 640x480 px, spin/up 320x240: its intrinsics are "
            "scaled by 0.5\n"
            "ceilmap: the rig's camera 'forward' has 640x480 px, spin/forward 320x240: its "
            "intrinsics are scaled by 0.5\n");
  ExpectMount();
  ExpectTruth("forward_yaw_deg", 2, 0.15);
  const calib::Rig found = calib::ReadRig(*folder_ / "new.yaml");
  EXPECT_EQ(found.up->camera.fx, 460);
  EXPECT_EQ(found.forward->camera.width_px, 640);
}

TEST_F(CalibrateRigTest, RecordingsOfTwoSizes) {
  std::filesystem::create_directory(*folder_ / "small");
  std::string image = "P5 160 120 255\n";
  image.append(160 * 120, 'x');
  folder_->Write("small/0.pgm", image);
  ExpectFault(Calibrate("spin/up", "small", {"--rig=rough.yaml", "--ceiling-height=2.5"}),
              "small: images are 160x120 px, those of spin/up 320x240; record both in one size");
}

TEST_F(CalibrateRigTest, AnAngleThatNothingTellsIsWarnedOf) {
  const support::ProcessResult result = Calibrate(
      "spin/up",
      "straight/up",
      {"--rig=ahead.yaml", "--ceiling-height=2.5", "--straight-forward=straight/forward"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("the forward camera's roll is known to "));
  EXPECT_THAT(result.err, HasSubstr(" deg only; add --spin-forward\n"));
}

TEST_F(CalibrateRigTest, ASpinThatIsNone) {
  const std::vector<std::string> more{"--rig=rough.yaml", "--ceiling-height=2.5"};
  support::ProcessResult result = Calibrate("straight/up", "straight/up", more);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(
      result.err,
      AllOf(
          StartsWith("ceilmap: straight/up: the robot turns by 0."),
          EndsWith(
              " deg only, must be at least 180; let it turn on the spot, best by a full turn\n")));
  result = Calibrate("drift/up", "straight/up", more);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("drift/up: the robot does not turn on the spot, its axle"));
}

TEST_F(CalibrateRigTest, AStraightDriveThatIsNone) {
  const std::vector<std::string> more{"--rig=rough.yaml", "--ceiling-height=2.5"};
  ExpectFault(Calibrate("spin/up", "curve/up", more),
              "curve/up: the robot turns by 4.0 deg on its straight drive, must be at most 2; let "
              "it drive straight ahead, on an even floor");
  std::filesystem::create_directory(*folder_ / "still");
  folder_->Write("still/0.png", ReadAll(*folder_ / "straight/up/000000.png"));
  folder_->Write("still/1.png", ReadAll(*folder_ / "straight/up/000000.png"));
  ExpectFault(Calibrate("spin/up", "still", more),
              "still: the robot drives only 0.00 m, must be at least 0.5; let it drive straight "
              "ahead as far as the room allows");
}

TEST_F(CalibrateRigTest, ACeilingThatIsLost) {
  std::filesystem::create_directory(*folder_ / "lost");
  for (int i = 0; i <= 30; ++i) {
    const bool here = i < 12;
    folder_->Write(
        fmt::format("lost/{:03}.png", i),
        ReadAll(*folder_ /
                fmt::format("{}/up/{:06}.png", here ? "spin" : "straight", here ? i : i % 2 * 20)));
  }
  const support::ProcessResult result =
      Calibrate("lost", "straight/up", {"--rig=rough.yaml", "--ceiling-height=2.5"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("lost: "));
}

TEST_F(CalibrateRigTest, ArgumentsThatDoNotFit) {
  ExpectFault(Calibrate("spin/up", "straight/up", {"--rig=rough.yaml"}),
              "calibrate rig: give --ceiling-height, or --distance of the straight drive; without "
              "a tape measure there is no scale");
  ExpectFault(Calibrate("spin/up", "straight/up", {"--ceiling-height=2.5"}),
              "calibrate rig: give either --rig RIG.yaml, or --camera CAMERA_INFO.yaml for a rig "
              "that does not exist yet");
  ExpectFault(Calibrate("spin/up", "straight/up", {"--rig=rough.yaml", "--ceiling-height=-2"}),
              "--ceiling-height -2: must be > 0, in metres");
  ExpectFault(
      Calibrate("spin/up",
                "straight/up",
                {"--camera=no.yaml", "--ceiling-height=2.5", "--spin-forward=spin/forward"}),
      "calibrate rig: a forward camera's recordings need its intrinsics and its place; give --rig "
      "instead of --camera, with cameras: forward in it");
  std::string no_pose = ReadAll(*folder_ / "rough.yaml");
  no_pose.resize(no_pose.find("    base_link_to_camera:"));
  folder_->Write("no-pose.yaml", no_pose);
  ExpectFault(Calibrate("spin/up", "straight/up", {"--rig=no-pose.yaml", "--distance=1.5"}),
              "no-pose.yaml: does not give the upward camera's height; give --camera-height, or "
              "both --ceiling-height and --distance");
}

}  // namespace
}  // namespace ceilmap::integration
