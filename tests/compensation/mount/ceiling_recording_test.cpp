#include "compensation/mount/ceiling_recording.hpp"

#include <gtest/gtest.h>

#include "tests/compensation/mount/calibration_drive.hpp"

namespace ceilmap::mount {
namespace {

class CeilingRecorderTest : public testing::Test {
 protected:
  simulator::Renderer renderer_{synthetic::Robot()};
  calib::Rig rig_ = synthetic::RoughRig(renderer_.GetRig());
  calib::CeilingView view_{*rig_.up, rig_.ceiling_height_m};
};

TEST_F(CeilingRecorderTest, KeepsTheFirstAndTheLastImage) {
  // A step of 1 cm is 2 px, between keyframes there are 14 px.
  const CeilingRecording drive =
      synthetic::Record("drive", renderer_, view_, synthetic::Straight(0.2, 20));
  EXPECT_EQ(drive.name, "drive");
  EXPECT_EQ(drive.frames, 21);
  ASSERT_GE(drive.keyframes.size(), 3U);
  EXPECT_LE(drive.keyframes.size(), 5U);
  const auto is_image = [&](const CeilingKeyframe& keyframe, int index) {
    const cv::Mat image = renderer_.Render(synthetic::Straight(0.2, 20)[index]);
    return cv::norm(keyframe.image, image, cv::NORM_INF) == 0;
  };
  EXPECT_TRUE(is_image(drive.keyframes.front(), 0));
  EXPECT_TRUE(is_image(drive.keyframes.back(), 20));
}

TEST_F(CeilingRecorderTest, PosesAreInUnitsOfTheCeilingsDistance) {
  const CeilingRecording drive =
      synthetic::Record("drive", renderer_, view_, synthetic::Straight(0.6, 12));
  const Pose2 motion = drive.keyframes.back().T_first_camera;
  const double distance_m = rig_.ceiling_height_m - rig_.up->T_base_cam.translation().z();
  // The unknown tilt of 1.2 degrees displaces the image alike in all views.
  EXPECT_NEAR(motion.Translation().norm(), 0.6 / distance_m, 0.005);
  EXPECT_NEAR(motion.yaw, 0, 0.2 * kRadPerDeg);
}

TEST_F(CeilingRecorderTest, TurnsAddUp) {
  const CeilingRecording spin =
      synthetic::Record("spin", renderer_, view_, synthetic::Spin(0.12, 30, 150));
  EXPECT_NEAR(std::abs(spin.keyframes.back().T_first_camera.yaw), 150 * kRadPerDeg, 0.01);
}

TEST(CeilingRecorder, FollowsACameraMountedAskewInLargeSteps) {
  simulator::Scene scene = synthetic::Robot();
  scene.camera.mount_pitch_deg = -9;
  scene.camera.mount_roll_deg = 10;
  const simulator::Renderer renderer(scene);
  const calib::Rig rig = synthetic::RoughRig(renderer.GetRig());
  const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
  CeilingRecorder recorder("spin", view);
  // The first steps are small, as those of a robot that starts.
  std::vector<simulator::Frame> frames = synthetic::Spin(0.12, 60, 120);
  for (int i = 0; i < 60; i += i < 12 ? 2 : 5) {
    EXPECT_TRUE(recorder.Add(renderer.Render(frames[static_cast<std::size_t>(i)]))) << i;
  }
  // The plane of the turn is not that of the image: the angle is a rough one.
  EXPECT_NEAR(
      std::abs(recorder.Finish().keyframes.back().T_first_camera.yaw), 114 * kRadPerDeg, 0.1);
}

TEST_F(CeilingRecorderTest, ManyKeyframesAreThinned) {
  const CeilingRecording spin =
      synthetic::Record("spin", renderer_, view_, synthetic::Spin(0.12, 110, 550));
  EXPECT_EQ(spin.frames, 111);
  EXPECT_LE(spin.keyframes.size(), 96U);
  EXPECT_GE(spin.keyframes.size(), 48U);
  EXPECT_NEAR(spin.keyframes.front().T_first_camera.yaw, 0, 1e-12);
}

TEST_F(CeilingRecorderTest, AnImageWithoutTheCeilingDoesNotMatch) {
  const std::vector<simulator::Frame> drive = synthetic::Straight(0.1, 5);
  CeilingRecorder recorder("drive", view_);
  EXPECT_TRUE(recorder.Add(renderer_.Render(drive[0])));
  EXPECT_FALSE(recorder.Add(cv::Mat(view_.Size(), CV_8UC1, cv::Scalar(9))));
  EXPECT_TRUE(recorder.Add(renderer_.Render(drive[1])));
  const CeilingRecording recording = recorder.Finish();
  EXPECT_EQ(recording.frames, 3);
  EXPECT_EQ(recording.keyframes.size(), 2U);
}

}  // namespace
}  // namespace ceilmap::mount
