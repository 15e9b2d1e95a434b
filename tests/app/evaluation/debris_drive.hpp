#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "app/evaluation/compensation.hpp"
#include "calib/base/degrees.hpp"

namespace ceilmap::evaluation {

/// A short drive over debris, and estimates of it, for tests of what compensation is worth.
constexpr double kUp = std::numbers::pi / 2;  // yaw along y of the truth: ahead is +y, left is -x

inline StampedPose Pose(double stamp_s, const Pose2& planar, TiltDegrees tilt = {}) {
  Tilt rad;
  rad.pitch_rad = tilt.pitch_deg * kRadPerDeg;
  rad.roll_rad = tilt.roll_deg * kRadPerDeg;
  return ToStampedPose(stamp_s, planar, rad);
}

/// Four metres along y, the third frame with its nose 4 degrees up and its left side 1 degree up.
inline std::vector<StampedPose> Truth() {
  return {Pose(0, {0, 0, kUp}),
          Pose(1, {0, 1, kUp}),
          Pose(2, {0, 2, kUp}, {-4, 1}),
          Pose(3, {0, 4, kUp})};
}

/// The frame that estimates are in.
inline const Pose2 kTruthMap{5, -3, 0.7};

/// Correct except for the third frame, which has this error in the frame of the truth.
inline std::vector<StampedPose> Estimate(const Eigen::Vector2d& off_m, TiltDegrees tilt = {}) {
  std::vector<StampedPose> poses;
  for (const StampedPose& truth : Truth()) {
    Pose2 T_truth_base{truth.position.x(), truth.position.y(), kUp};
    const bool third = truth.stamp_s == 2;
    if (third) {
      T_truth_base.x += off_m.x();
      T_truth_base.y += off_m.y();
    }
    poses.push_back(
        Pose(truth.stamp_s, kTruthMap.Inverse() * T_truth_base, third ? tilt : TiltDegrees{}));
  }
  return poses;
}

/// 20 cm behind and 5 cm to the right becomes 2 cm ahead and 1 cm to the left.
inline const Eigen::Vector2d kBefore(0.05, -0.2);
inline const Eigen::Vector2d kAfter(-0.01, 0.02);

}  // namespace ceilmap::evaluation
