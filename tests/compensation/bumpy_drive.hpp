#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/base/tilt.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/renderer.hpp"

/// Rendered images of the room of samples/scenes/debris.yaml, small ones, for the tests of what
/// measures tilt.
namespace ceilmap::compensation::synthetic {

/// Cameras of 320 x 240 px; two metres towards the right wall, and nothing on the floor.
inline simulator::Scene Lab() {
  simulator::Scene scene = simulator::ReadScene(std::filesystem::path(CEILMAP_SOURCE_DIR) /
                                                "samples/scenes/debris.yaml");
  for (simulator::Camera* camera : {&scene.camera, &*scene.forward}) {
    camera->width_px /= 2;
    camera->height_px /= 2;
    camera->focal_px /= 2;
  }
  scene.path.waypoints_m = {{2.6, 2.6}, {4.6, 3.0}};
  scene.path.speed_m_s = 0.4;
  scene.debris.bumps.clear();
  return scene;
}

/// The same over two bumps: one lifts the front by 4.6 degrees, one the left side by 2. 40 frames.
inline simulator::Scene BumpyLab() {
  simulator::Scene scene = Lab();
  scene.path.max_frames = 40;
  scene.debris.bumps = {{0.25, 0.35, 4.6, 0}, {0.8, 0.35, 0, 2}};
  return scene;
}

/// A frame of a robot at rest at a pose in space.
inline simulator::Frame FrameAt(std::int64_t index, const Pose2& pose, const Tilt& tilt = {}) {
  simulator::Frame frame = simulator::StillFrame(index, pose);
  frame.T_map_base = ToSpace(pose, tilt);
  frame.T_map_base_open = frame.T_map_base_close = frame.T_map_base;
  frame.T_map_base_forward_open = frame.T_map_base_forward_close = frame.T_map_base;
  return frame;
}

/// Front wheels that climb: degrees of nose up, and the lift that goes with them.
inline Tilt FrontUp(double deg, double axle_behind_mast_m, double roll_deg = 0) {
  return {-deg * kRadPerDeg,
          roll_deg * kRadPerDeg,
          axle_behind_mast_m * std::sin(deg * kRadPerDeg),
          Eigen::Matrix2d::Zero()};
}

}  // namespace ceilmap::compensation::synthetic
