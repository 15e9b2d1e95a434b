#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "calib/base/pose2.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Time and poses of one image. p_map = T_map_base * p_base.
struct Frame {
  std::int64_t index = 0;
  double stamp_s = 0;  ///< middle of the exposure, the time of the pose
  Eigen::Isometry3d T_map_base = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_map_base_open =
      Eigen::Isometry3d::Identity();  ///< at the beginning of the exposure, of any row
  Eigen::Isometry3d T_map_base_close =
      Eigen::Isometry3d::Identity();  ///< at the end of the exposure, of any row
  // The same for the forward camera, whose exposure has the same middle and may be longer.
  Eigen::Isometry3d T_map_base_forward_open = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_map_base_forward_close = Eigen::Isometry3d::Identity();
  /// Of the upward camera's automatic exposure, in addition to that of Image; by FollowExposure().
  double auto_gain = 1;
};

/// A frame of a robot at rest on the level floor.
Frame StillFrame(std::int64_t index, const Pose2& T_map_base, double stamp_s = 0);

/// Distance travelled by the axle on the whole path of a valid scene, metres; 0 for PathKind::kTum.
double PathLength(const Scene& scene);

/// Maximum number of frames: four days at 30 frames a second, some GB.
inline constexpr std::int64_t kMaxFrames = 10'000'000;

/// The frames of the scene's drive, at most path.max_frames if that is not 0. Never empty.
/// @throws InputError when the scene is not valid, the drive is longer than kMaxFrames, the given
/// poses (PathKind::kTum) cannot be used, or the robot is carried to where a camera leaves the
/// room.
std::vector<Frame> MakePath(const Scene& scene);

}  // namespace ceilmap::simulator
