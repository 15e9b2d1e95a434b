#include "ceilmap_ros/logic/map_to_odom.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/base/error.hpp"

namespace ceilmap_ros {
namespace {

void RequireAtLeast(const char* name, double value, double min, bool without_min) {
  if (std::isfinite(value) && (without_min ? value > min : value >= min)) return;
  throw ceilmap::InputError(
      fmt::format("{} = {}, must be {} {}", name, value, without_min ? ">" : ">=", min));
}

}  // namespace

void MapToOdomOptions::Validate() const {
  RequireAtLeast("transform_tolerance", transform_tolerance_s, 0, true);
  RequireAtLeast("predicted_sigma", predicted_sigma_m, 0, false);
  RequireAtLeast("predicted_sigma_yaw", predicted_sigma_rad, 0, false);
}

std::optional<PoseWithCovariance> SurePose(const robot::Estimate& estimate,
                                           const MapToOdomOptions& params) {
  if (estimate.HasPose()) return estimate.pose;
  if (estimate.status != robot::TrackingStatus::kPredicted) return std::nullopt;
  const auto& covariance = estimate.pose.covariance;
  const double sigma_m = std::sqrt(0.5 * covariance.topLeftCorner<2, 2>().trace());
  const double sigma_rad = std::sqrt(covariance(2, 2));
  if (sigma_m <= params.predicted_sigma_m && sigma_rad <= params.predicted_sigma_rad) {
    return estimate.pose;
  }
  return std::nullopt;
}

std::optional<MapToOdom> ComputeMapToOdom(Stamp stamp,
                                          const Pose2& T_map_base,
                                          const OdometryAnswer& odometry,
                                          const MapToOdomOptions& params) {
  if (!odometry.Known()) return std::nullopt;
  return MapToOdom{T_map_base * odometry.T_odom_base.Inverse(),
                   stamp + FromSeconds(params.transform_tolerance_s)};
}

}  // namespace ceilmap_ros
