#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/base/pose2.hpp"

namespace ceilmap::localization {

/// Motion of the robot between two frames, as the ceiling shows it while its place is not known.
struct ChainStep {
  Pose2 T_before_now;  ///< from the last frame placed in the chain
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of its (x, y, yaw), in the frame before
  /// Several motions explain the images; the constant-velocity model alone chose this one (periodic
  /// ceiling).
  bool disambiguated_by_prior = false;
  /// Later frames are compared with this frame, or the one before it, instead of earlier ones.
  bool new_keyframe = false;
  /// Fraction of the blocks that agree, 0..1.
  double inlier_ratio = 0;
  /// Only all blocks together showed the motion (Registration::jointly): in another light, or with
  /// more noise, such an image may show nothing.
  bool weak = false;

  /// What was measured: the motion since the image with which the frame was compared. The motions
  /// since one keyframe have its errors in common, and no others.
  struct SinceKeyframe {
    Pose2 T_keyframe_now;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of its (x, y, yaw)
    bool is_frame_before = false;                          ///< the keyframe is the frame before
  };
  /// Nothing where the keyframe is neither the frame before nor that of the step before.
  std::optional<SinceKeyframe> since_keyframe;
};

}  // namespace ceilmap::localization
