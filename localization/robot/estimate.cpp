#include "localization/robot/estimate.hpp"

namespace ceilmap::robot {

graph::FramePose ToFramePose(const Estimate& estimate) {
  graph::FramePose pose;
  pose.frame_index = estimate.index;
  pose.stamp_s = estimate.stamp_s;
  pose.status = estimate.status;
  pose.T_map_base = estimate.pose.pose;
  pose.covariance = estimate.pose.covariance;
  pose.tilt = estimate.tilt;
  pose.heading = estimate.heading;
  pose.keyframe_id = estimate.keyframe_id;
  return pose;
}

Estimate InSite(const Estimate& estimate, const survey::SiteFrame& site) {
  Estimate result = estimate;
  if (estimate.HasPose() || estimate.status == TrackingStatus::kPredicted) {
    result.pose = survey::ToSite(site, estimate.pose);
  }
  for (WeightedPose& place : result.places) place.pose = site.S_site_map * place.pose;
  return result;
}

}  // namespace ceilmap::robot
