#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "calib/base/pose2.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// One image to take: when, and where the robot is meanwhile. p_map = T_map_base * p_base.
struct Frame {
  std::int64_t index = 0;
  double stamp_s = 0;  ///< middle of the exposure, and so is the pose
  Eigen::Isometry3d T_map_base = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_map_base_open = Eigen::Isometry3d::Identity();   ///< exposure begins
  Eigen::Isometry3d T_map_base_close = Eigen::Isometry3d::Identity();  ///< exposure ends
  // The same of the forward camera, whose exposure has the same middle and may be longer.
  Eigen::Isometry3d T_map_base_forward_open = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_map_base_forward_close = Eigen::Isometry3d::Identity();
};

/// A frame of a robot at rest on the level floor.
Frame StillFrame(std::int64_t index, const Pose2& T_map_base, double stamp_s = 0);

/// Metres that the axle travels on the whole path of a valid scene; 0 for PathKind::kTum.
double PathLength(const Scene& scene);

/// What a drive may have: four days at 30 frames a second, some GB.
inline constexpr std::int64_t kMaxFrames = 10'000'000;

/// The frames of the scene's drive, at most path.max_frames when that is not 0. Never empty.
/// @throws InputError when the scene is not valid, the drive is longer than kMaxFrames, or
///   given poses (PathKind::kTum) cannot be used.
std::vector<Frame> MakePath(const Scene& scene);

}  // namespace ceilmap::simulator
