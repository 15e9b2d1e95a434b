#pragma once

#include <optional>

#include "calib/base/pose_with_covariance.hpp"
#include "ceilmap_ros/logic/odometry_buffer.hpp"
#include "ceilmap_ros/logic/stamp.hpp"
#include "localization/robot/estimate.hpp"

namespace ceilmap_ros {

using ceilmap::PoseWithCovariance;
namespace robot = ceilmap::robot;

/// A transform map -> odom for TF, as REP-105 has it: p_map = T_map_odom * p_odom.
struct MapToOdom {
  Pose2 T_map_odom;
  /// The stamp that it is published with: until then TF extrapolates nothing.
  Stamp valid_until = 0;
};

struct MapToOdomOptions {
  /// A transform is stamped later than its image by this, as AMCL does, s, > 0.
  double transform_tolerance_s = 0.5;
  /// A pose that the wheels alone predict is used up to this standard deviation of its position, m,
  /// >= 0, ...
  double predicted_sigma_m = 0.1;
  /// ... and of its yaw, rad, >= 0.
  double predicted_sigma_rad = 0.05;

  /// @throws InputError that names the value and its range.
  void Validate() const;
};

/// The pose that the robot may rely on: the one that the image determined, or that the wheels
/// predict with a small covariance. Nothing while its place is not known.
std::optional<PoseWithCovariance> SurePose(const robot::Estimate& estimate,
                                           const MapToOdomOptions& params);

/// T_map_odom = T_map_base * inverse(T_odom_base), both at the stamp of the image.
/// @return nothing when the odometry is not known there.
std::optional<MapToOdom> ComputeMapToOdom(Stamp stamp,
                                          const Pose2& T_map_base,
                                          const OdometryAnswer& odometry,
                                          const MapToOdomOptions& params);

}  // namespace ceilmap_ros
