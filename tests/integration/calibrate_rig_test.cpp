// `calibrate rig` through the real executable, on simulated recordings of a rig that is known.

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "calib/rig.hpp"
#include "tests/integration/calibrate_rig_recordings.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

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
  write_slow("slow-spin.csv", kSpinSteps);
  write_slow("slow-straight.csv", kDriveSteps);
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

// The rig describes the cameras at twice the size of the recordings.
TEST_F(CalibrateRigTest, SpinAndDriveDetermineTheForwardCameraOfAScaledRig) {
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
  ExpectTruth("forward_pitch_deg", 4, 0.15);
  ExpectTruth("forward_roll_deg", -1, 0.15);
  const calib::Rig found = calib::ReadRig(*folder_ / "new.yaml");
  EXPECT_EQ(found.up->camera.fx, 460);
  EXPECT_EQ(found.forward->camera.width_px, 640);
  const calib::Rig truth = calib::ReadRig(*folder_ / "spin/rig.yaml");
  const Eigen::AngleAxisd off(found.forward->T_base_cam.linear().transpose() *
                              truth.forward->T_base_cam.linear());
  EXPECT_LT(off.angle() / kRadPerDeg, 0.2);
  EXPECT_DOUBLE_EQ(found.forward->T_base_cam.translation().z(), 0.45);
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
  EXPECT_THAT(result.err, testing::Not(HasSubstr("scaled"))) << "the rig has the recordings' size";
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
    folder_->Write(fmt::format("lost/{:03}.png", i),
                   ReadAll(*folder_ / fmt::format("{}/up/{:06}.png",
                                                  here ? "spin" : "straight",
                                                  here ? i : i % 2 * kDriveSteps)));
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
