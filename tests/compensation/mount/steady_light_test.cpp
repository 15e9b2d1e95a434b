#include "compensation/mount/steady_light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"
#include "tests/compensation/flickering_room.hpp"

namespace ceilmap::mount {
namespace {

/// Seen by a camera that is mounted askew.
simulator::Scene FlickeringRoom(double flicker_depth) {
  simulator::Scene scene = compensation::synthetic::FlickeringRoom();
  scene.camera.mount_x_m = 0.1;
  scene.camera.mount_yaw_deg = 30;
  scene.camera.mount_pitch_deg = 6;
  scene.image.flicker_depth = flicker_depth;
  scene.path.max_frames = 20;
  return scene;
}

Pose2 PoseOf(const Eigen::Isometry3d& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T.linear()(1, 0), T.linear()(0, 0))};
}

struct FlickerDrive {
  explicit FlickerDrive(const simulator::Scene& scene) : renderer(scene) {
    const calib::Rig& rig = renderer.GetRig();
    const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
    const Pose2 T_base_camera = PoseOf(view.T_base_camera());
    const double distance_m = rig.ceiling_height_m - rig.up->T_base_cam.translation().z();
    recording.has_stamps = true;
    for (const simulator::Frame& frame : simulator::MakePath(scene)) {
      const Pose2 T_map_camera = PoseOf(frame.T_map_base) * T_base_camera;
      if (cameras.empty()) first = T_map_camera;
      Pose2 T_first_camera = first.Inverse() * T_map_camera;
      T_first_camera.x /= distance_m;
      T_first_camera.y /= distance_m;
      cameras.push_back(T_first_camera);
      recording.keyframes.push_back({renderer.Render(frame), T_first_camera, {}, frame.stamp_s});
    }
  }

  [[nodiscard]] CeilingRecording Without(double readout_time_s) const {
    return Without(recording, readout_time_s);
  }
  [[nodiscard]] CeilingRecording Without(const CeilingRecording& images,
                                         double readout_time_s) const {
    calib::MountedCamera up = *renderer.GetRig().up;
    up.readout_time_s = readout_time_s;
    return WithoutFlicker(images, cameras, up, renderer.GetRig().ceiling_height_m);
  }

  simulator::Renderer renderer;
  CeilingRecording recording;
  std::vector<Pose2> cameras;
  Pose2 first;
};

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

// The drives that all tests share: rendered once.
const FlickerDrive& Flickering() {
  static const FlickerDrive drive(FlickeringRoom(0.3));
  return drive;
}
const FlickerDrive& Steady() {
  static const FlickerDrive drive(FlickeringRoom(0));
  return drive;
}

TEST(SteadyLight, BandsAreRemovedFromAllImages) {
  const FlickerDrive& drive = Flickering();
  const CeilingRecording removed = drive.Without(0.025);
  for (std::size_t i = 0; i < drive.cameras.size(); ++i) {
    const cv::Mat& wanted = Steady().recording.keyframes[i].image;
    const double before = MeanDifference(drive.recording.keyframes[i].image, wanted);
    EXPECT_GT(before, 5) << i;  // grey levels; noise is below one
    EXPECT_LT(MeanDifference(removed.keyframes[i].image, wanted), 0.25 * before) << i;
  }
}

// A calibration finds the read-out time in rounds.
TEST(SteadyLight, AnErrorOfTheReadoutTimeLeavesAPart) {
  const FlickerDrive& drive = Flickering();
  const cv::Mat wanted = Steady().recording.keyframes.back().image;
  const double before = MeanDifference(drive.recording.keyframes.back().image, wanted);
  EXPECT_LT(MeanDifference(drive.Without(0.023).keyframes.back().image, wanted), 0.5 * before);
}

TEST(SteadyLight, ImagesAreNotTouchedWithoutBandsReadoutOrStamps) {
  const auto expect_same =
      [](const FlickerDrive& drive, const CeilingRecording& recording, double readout_time_s) {
        const CeilingRecording same = drive.Without(recording, readout_time_s);
        for (std::size_t i = 0; i < drive.cameras.size(); ++i) {
          EXPECT_EQ(same.keyframes[i].image.data, recording.keyframes[i].image.data) << i;
        }
      };
  expect_same(Steady(), Steady().recording, 0.025);
  CeilingRecording recording = Flickering().recording;
  expect_same(Flickering(), recording, 0);
  recording.has_stamps = false;
  expect_same(Flickering(), recording, 0.025);
}

}  // namespace
}  // namespace ceilmap::mount
