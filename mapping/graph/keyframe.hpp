#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/heading.hpp"
#include "calib/base/pose2.hpp"
#include "calib/base/tilt.hpp"
#include "mapping/heights/height_field.hpp"

namespace ceilmap::graph {

/// Whether a frame has a pose, and how it was obtained. A pose that is not known is reported as
/// such, never guessed.
enum class TrackingStatus {
  kTracking,
  kRelocalized,
  kPredicted,  ///< by wheels alone: the image did not contribute
  kAmbiguous,
  kLost
};
const char* ToString(TrackingStatus status);
/// Whether the frame's image determined its pose.
constexpr bool HasPose(TrackingStatus status) {
  return status == TrackingStatus::kTracking || status == TrackingStatus::kRelocalized;
}

/// One video frame's pose on the map.
struct FramePose {
  std::int64_t frame_index = 0;
  double stamp_s = 0;
  TrackingStatus status = TrackingStatus::kTracking;
  Pose2 T_map_base;  ///< pose of the mast's foot, for a tilted robot too
  /// Measured tilt of the robot; level where it was not measured. The image is corrected to that of
  /// a level robot.
  Tilt tilt;
  /// Heading of a compass, in the compass' own frame. Not stored in map files: it has no meaning
  /// for other recordings.
  std::optional<HeadingPrior> heading;
  /// Covariance of (x, y, yaw) in the map frame; m^2, m rad, rad^2 (pixels for metres without a
  /// rig).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// The keyframe against which the frame was measured; its own id for a keyframe. When a loop
  /// closure moves that keyframe, the frame moves with it. -1: none.
  std::int64_t keyframe_id = -1;
};

/// A stored frame: its image becomes part of the mosaic, and later frames are registered against
/// it.
struct Keyframe {
  std::int64_t id = 0;  ///< 0, 1, 2, ... in order of time
  FramePose pose;
  /// CV_8UC1, rectified (CeilingView), level (LevelView): 0 exactly where there is no content. May
  /// be empty where only poses are needed.
  cv::Mat image;
  /// Several motions explained its image equally well, and the prediction alone selected one
  /// (strictly periodic ceiling, Registration::disambiguated_by_prior).
  bool ambiguous = false;
  /// Heights of the ceiling in the image; nullptr: the ceiling is taken to be plane there.
  std::shared_ptr<const heights::HeightField> heights = nullptr;
};

/// Loads the image of a keyframe (CV_8UC1, rectified) from its storage.
using ImageLoader = std::function<cv::Mat(std::int64_t keyframe_id)>;

/// A motion between two keyframes, measured or known by the wheels: an edge of the pose graph.
struct Edge {
  enum class Kind {
    kOdometry,     ///< measured by the images of neighbours in time
    kLoopClosure,  ///< measured by the images of neighbours in space
    kWheels,       ///< known by the wheels alone, over a stretch where the images show nothing
  };
  std::int64_t from = 0;
  std::int64_t to = 0;
  Kind kind = Kind::kOdometry;
  Pose2 T_from_to;  ///< p_from = T_from_to * p_to, both base frames
  /// Inverse covariance of T_from_to's (x, y, yaw), expressed in frame `from`.
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();
};

}  // namespace ceilmap::graph
