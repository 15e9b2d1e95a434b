#pragma once

#include <Eigen/Core>

#include "calib/base/pose2.hpp"

namespace ceilmap {

/// Velocity of a base frame in the plane of the floor, in its own axes.
struct Twist2 {
  Eigen::Vector2d linear_m_s = Eigen::Vector2d::Zero();
  double yaw_rad_s = 0;  ///< > 0: turns left

  /// Mean velocity of a robot that turns evenly from one pose to the next. @param duration_s > 0.
  static Twist2 Mean(const Pose2& T_before_now, double duration_s) {
    const Pose2 half_back{0, 0, -T_before_now.yaw / 2};
    return {half_back.Rotation() * T_before_now.Translation() / duration_s,
            T_before_now.yaw / duration_s};
  }
  /// The inverse of Mean: T_now_later of a robot that turns evenly with this mean velocity.
  [[nodiscard]] Pose2 Over(double duration_s) const {
    const double yaw = yaw_rad_s * duration_s;
    const Eigen::Vector2d way = Pose2{0, 0, yaw / 2}.Rotation() * (duration_s * linear_m_s).eval();
    return {way.x(), way.y(), yaw};
  }
};

/// A velocity at a time.
struct StampedTwist2 {
  double stamp_s = 0;
  Twist2 velocity;
};

}  // namespace ceilmap
