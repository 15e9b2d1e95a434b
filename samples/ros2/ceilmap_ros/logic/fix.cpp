#include "ceilmap_ros/logic/fix.hpp"

#include <algorithm>

namespace ceilmap_ros {

Fix MakeFix(const Batch& batch, const robot::Estimate& estimate, const MapToOdomOptions& params) {
  Fix fix;
  fix.stamp = batch.frame.stamp;
  fix.estimate = estimate;
  fix.odometry = batch.odometry_at_frame.kind;
  fix.pose = SurePose(estimate, params);
  if (fix.pose) {
    fix.map_to_odom = ComputeMapToOdom(fix.stamp, fix.pose->pose, batch.odometry_at_frame, params);
  }
  return fix;
}

void AddSensors(const Batch& batch, Timeline& timeline, robot::Sensors& sensors) {
  for (const OdometryPose& sample : batch.odometry) {
    sensors.AddOdometry(
        ceilmap::wheels::OdometrySample{timeline.At(sample.stamp), sample.T_odom_base});
  }
  for (const StampedRate& sample : batch.gyro) {
    sensors.AddGyro({timeline.At(sample.stamp), sample.yaw_rate_rad_s});
  }
  for (const StampedImage& image : batch.forward) {
    sensors.AddForward({image.pixels, timeline.At(image.stamp), 0});
  }
  for (const StampedImage& image : batch.omni) {
    sensors.AddOmni({image.pixels, timeline.At(image.stamp), 0});
  }
}

Stamp EarliestStamp(const Batch& batch) {
  Stamp earliest = batch.frame.stamp;
  const auto take_first = [&earliest](const auto& samples) {
    if (!samples.empty()) earliest = std::min(earliest, samples.front().stamp);
  };
  take_first(batch.odometry);
  take_first(batch.gyro);
  take_first(batch.forward);
  take_first(batch.omni);
  return earliest;
}

}  // namespace ceilmap_ros
