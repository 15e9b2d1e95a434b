#pragma once

#include <optional>

#include "ceilmap_ros/logic/inbox.hpp"
#include "ceilmap_ros/logic/map_to_odom.hpp"
#include "ceilmap_ros/logic/stamp.hpp"
#include "localization/robot/sensors.hpp"

namespace ceilmap_ros {

/// The result of one image.
struct Fix {
  Stamp stamp = 0;
  robot::Estimate estimate;
  std::optional<PoseWithCovariance> pose;  ///< T_map_base, to be published; nothing: not sure
  std::optional<MapToOdom> map_to_odom;    ///< to be published with it
  OdometryAnswer::Kind odometry = OdometryAnswer::Kind::kNone;  ///< at the image's time
};

/// What of an estimate may be published.
Fix MakeFix(const Batch& batch, const robot::Estimate& estimate, const MapToOdomOptions& params);

/// Hands over all that belongs to the frame of a batch, before the frame itself.
void AddSensors(const Batch& batch, Timeline& timeline, robot::Sensors& sensors);

/// Where a clock that was reset began again: the earliest stamp of the batch.
Stamp EarliestStamp(const Batch& batch);

}  // namespace ceilmap_ros
