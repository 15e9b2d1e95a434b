#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/heading.hpp"
#include "calib/base/pose_with_covariance.hpp"
#include "calib/base/tilt.hpp"
#include "calib/base/weighted_pose.hpp"
#include "localization/localizer.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/survey/site_frame.hpp"

namespace ceilmap::robot {

using graph::TrackingStatus;

/// What is known of the robot at an upward frame. Nothing is guessed: without HasPose() there is no
/// pose.
struct Estimate {
  double stamp_s = 0;
  std::int64_t index = 0;  ///< of the image (Image::index)
  TrackingStatus status = TrackingStatus::kLost;
  PoseWithCovariance pose;              ///< T_map_base; (x, y, yaw) in map axes
  Tilt tilt;                            ///< that was taken out of the image
  std::optional<HeadingPrior> heading;  ///< as measured, in its own frame
  double peak = 0;     ///< agreement of the image with the map, 0..1 (CeilingLocalizer)
  int inliers = 0;     ///< blocks of the image that agree with the map (CeilingLocalizer)
  int blocks = 0;      ///< blocks compared (CeilingLocalizer)
  int hypotheses = 0;  ///< places where the robot may be, while its pose is unknown
  std::vector<WeightedPose> places;  ///< these places, weights sum to 1 (CeilingLocalizer)
  /// The image as it was matched (CeilingLocalizer); valid until the localizer's next frame.
  std::optional<localization::SeenCeiling> seen = {};
  std::int64_t keyframe_id = -1;  ///< against which the frame was measured (CeilingMapper)

  [[nodiscard]] bool HasPose() const { return graph::HasPose(status); }
};

/// The same as a frame's pose in a map's trajectory.
graph::FramePose ToFramePose(const Estimate& estimate);

/// The same in the coordinates of the building: pose, covariance (with the error of the alignment)
/// and possible places. The heading as measured and the tilt stay as they are.
Estimate InSite(const Estimate& estimate, const survey::SiteFrame& site);

}  // namespace ceilmap::robot
