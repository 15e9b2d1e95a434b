#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>

#include "calib/camera.hpp"
#include "calib/mirror.hpp"

namespace ceilmap::calib {

/// A camera on the robot.
struct MountedCamera {
  PinholeCamera camera;  ///< focal lengths 0: not known, only with mirror_ring
  /// p_base = T_base_cam * p_cam; cam is the optical frame.
  Eigen::Isometry3d T_base_cam = Eigen::Isometry3d::Identity();
  double exposure_time_s = 0;
  std::optional<HyperbolicMirror> mirror;  ///< only for type hyperbolic_mirror
  std::optional<MirrorRing> mirror_ring;   ///< only for type mirror, whose shape is not known
};

/// What a robot carries, as read from rig.yaml. base: foot of the camera mast on the floor, x
/// forward, y left, z up.
struct Rig {
  std::string robot;
  double axle_behind_mast_m = 0;           ///< `a`: the axle stands at base x = -a; may be negative
  std::optional<double> forward_height_m;  ///< `d`: forward camera above the floor, > 0
  double ceiling_height_m = 0;             ///< `h`: ceiling above the floor, > 0
  std::optional<MountedCamera> up;
  std::optional<MountedCamera> forward;
  std::optional<MountedCamera> omni;
  std::string source_yaml;  ///< the file's text as read, kept for provenance
};

/// Reads rig.yaml (format: calib/README.md). A camera's intrinsics stand inline in the manner of
/// ROS camera_info or in a camera_info file of their own (`camera_info: PATH`, relative to
/// rig.yaml).
///
/// @throws InputError `FILE:LINE: KEY = VALUE, must be ...; how to mend` when a key is missing,
///   unknown, of the wrong type, or impossible (focal length <= 0, image size <= 0, pose not
///   orthonormal, matrix and quaternion that disagree, ceiling not above the upward camera, upward
///   camera that does not look up, ...), and when the file is missing, empty, no YAML or larger
///   than 1 MiB.
Rig ReadRig(const std::filesystem::path& file);

/// The same from a text. @param file  its name in messages; its folder is where a relative
/// `camera_info` path starts.
Rig ParseRig(const std::string& text, const std::filesystem::path& file);

}  // namespace ceilmap::calib
