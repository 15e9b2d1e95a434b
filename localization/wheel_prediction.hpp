#pragma once

#include <optional>

#include "calib/base/pose_with_covariance.hpp"
#include "calib/wheels/relative_motion.hpp"

namespace ceilmap::localization {

/// Where the robot is by its wheels alone since its pose was measured last. Internal to Localizer.
class WheelPrediction {
 public:
  /// The pose of the current frame is known.
  void Start(const PoseWithCovariance& measured);
  /// Forgets the pose: the robot may be anywhere.
  void Stop();
  /// The next frame. @param step  Motion since the frame before; nothing: it is not known, nor is
  /// the pose from now on.
  void Move(const std::optional<wheels::RelativeMotion>& step);
  /// What the frame shows contradicts the predicted pose, or agrees with it. A robot whose wheels
  /// stand still may be carried away: after some frames of contradiction nothing is predicted.
  void Contradict(bool contradicts);
  /// Whether the latest frame contradicted the predicted pose.
  [[nodiscard]] bool IsContradicted() const { return contradictions_ > 0; }

  /// Nothing where it is not known, or too uncertain to be of use.
  [[nodiscard]] std::optional<PoseWithCovariance> Pose() const;
  /// Since the pose was known.
  [[nodiscard]] const std::optional<wheels::RelativeMotion>& Motion() const { return motion_; }

 private:
  PoseWithCovariance start_;
  std::optional<wheels::RelativeMotion> motion_;
  int contradictions_ = 0;  // consecutive
};

}  // namespace ceilmap::localization
