#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calib/pose2.hpp"
#include "calib/tilt.hpp"

namespace ceilmap::app {

/// One line of a trajectory file: the pose of base in the map, p_map = orientation * p_base +
/// position.
struct StampedPose {
  double stamp_s = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< metres (pixels without a rig)
  /// As the file spells it: of unit length only up to its rounding.
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
};

/// A robot whose foot stands at a planar pose, level on the floor unless it is tilted.
StampedPose ToStampedPose(double stamp_s,
                          const calib::Pose2& T_map_base,
                          const calib::Tilt& tilt = {});

/// Turn about the vertical in (-pi, pi], counter-clockwise seen from above (z-y-x Euler angles).
double YawOf(const StampedPose& pose);
/// The other two of these angles by REP-103: pitch in [-pi/2, pi/2], > 0 with the nose down; roll
/// in (-pi, pi], > 0 with the left side up.
double PitchOf(const StampedPose& pose);
double RollOf(const StampedPose& pose);

/// The comment line that names the columns of a trajectory file, and one of its lines.
std::string_view TumHeader();
std::string FormatTumLine(const StampedPose& pose);

/// The trajectory as TUM lines `timestamp tx ty tz qx qy qz qw` under one comment line that names
/// the columns: stamps to the microsecond, lengths to the nanometre, quaternions of unit length to
/// 1e-9.
std::string FormatTum(const std::vector<StampedPose>& poses);

/// Reads TUM lines; `#` starts a comment.
/// @return at least one pose; stamps strictly increasing, numbers finite, quaternions of unit
/// length
///   to 1e-3 (files with four digits exist).
/// @throws calib::InputError naming file and line.
std::vector<StampedPose> ReadTum(const std::filesystem::path& file);

}  // namespace ceilmap::app
