#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// Interpolates the position and yaw of a robot between its poses.
class PlanarTrack {
 public:
  struct Point {
    Eigen::Vector2d position = Eigen::Vector2d::Zero();
    double yaw = 0;  ///< continuous over full turns
  };

  /// @param poses  Stamps strictly increasing, at least one.
  explicit PlanarTrack(const std::vector<StampedPose>& poses);

  [[nodiscard]] double Start() const { return stamps_s_.front(); }
  [[nodiscard]] double End() const { return stamps_s_.back(); }
  /// Median time between neighbouring poses, s.
  [[nodiscard]] double MedianStep() const { return median_step_s_; }

  /// Linear interpolation between neighbouring poses.
  /// @return unset before the first pose, after the last, and in gaps. A gap is longer than one
  ///   second and longer than five median steps.
  [[nodiscard]] std::optional<Point> At(double stamp_s) const;

 private:
  std::vector<double> stamps_s_;
  std::vector<Point> points_;
  double median_step_s_ = 0;
};

}  // namespace ceilmap::evaluation
