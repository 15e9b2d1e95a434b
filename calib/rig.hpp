#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/lens.hpp"
#include "calib/mirror.hpp"
#include "calib/wheels/wheel_model.hpp"

namespace ceilmap::calib {

/// What a rig states about the virtual image of its upward camera; the rest is chosen from the
/// lens.
struct ViewChoice {
  std::optional<double> field_of_view_rad;  ///< along the width
  std::optional<cv::Size> size;
  /// Where neither of these is given: largest angle from the vertical, of half the diagonal. Not in
  /// rig files: localization limits the view to what its map shows.
  std::optional<double> max_angle_rad = std::nullopt;
};

/// A camera on the robot.
struct MountedCamera {
  Lens camera;  ///< focal lengths 0: not known, only with mirror_ring
  /// p_base = T_base_cam * p_cam; cam is the optical frame.
  Eigen::Isometry3d T_base_cam = Eigen::Isometry3d::Identity();
  double exposure_time_s = 0;
  /// Rolling shutter: from the exposure of the first row to that of the last one; < 0: the last row
  /// is first. Stamps are of the middle row. Only for the upward camera.
  double readout_time_s = 0;
  std::optional<ViewChoice> view;          ///< only for the upward camera
  std::optional<HyperbolicMirror> mirror;  ///< only for type hyperbolic_mirror
  std::optional<MirrorRing> mirror_ring;   ///< only for type mirror, of unknown shape
};

/// The cameras and dimensions of a robot, as read from rig.yaml. base: foot of the camera mast on
/// the floor, x forward, y left, z up.
struct Rig {
  std::string robot;
  double axle_behind_mast_m = 0;           ///< `a`: the axle stands at base x = -a; may be negative
  std::optional<double> forward_height_m;  ///< `d`: forward camera above the floor, > 0
  double ceiling_height_m = 0;             ///< `h`: ceiling above the floor, > 0
  std::optional<MountedCamera> up;
  std::optional<MountedCamera> forward;
  std::optional<MountedCamera> omni;
  std::optional<wheels::WheelModel> wheels;  ///< as measured before
  std::filesystem::path file;                ///< where it was read from, for messages
  std::string source_yaml;                   ///< the file's text as read, kept for provenance
  /// Values that the file does not give and that are usual, one line for each: "a = 0: ...".
  std::vector<std::string> assumed;
};

/// Reads rig.yaml (format: calib/README.md). The intrinsics of a camera are given inline in the
/// form of ROS camera_info or in a separate camera_info file (`camera_info: PATH`, relative to
/// rig.yaml). `a`, the distortion and the rotation of a camera have defaults (calib/README.md,
/// "Defaults").
///
/// @throws InputError `FILE:LINE: KEY = VALUE, must be ...; how to fix it` when a key is missing,
///   unknown, of the wrong type, or impossible (focal length <= 0, image size <= 0, pose not
///   orthonormal, matrix and quaternion that disagree, ceiling not above the upward camera, upward
///   camera that does not point up, ...), and when the file is missing, empty, no YAML or larger
///   than 1 MiB.
Rig ReadRig(const std::filesystem::path& file);

/// The same from a text. @param file its name in messages; a relative `camera_info` path starts at
/// its folder.
Rig ParseRig(const std::string& text, const std::filesystem::path& file);

}  // namespace ceilmap::calib
