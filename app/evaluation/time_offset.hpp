#pragma once

#include <optional>
#include <vector>

#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// Offset between two clocks that recorded the same drive.
struct TimeOffset {
  double offset_s = 0;  ///< stamp of the truth = stamp of the estimate + offset_s
  /// Standard deviation of offset_s from the remaining errors, assuming that they are independent.
  double sigma_s = 0;
  double correlation = 0;  ///< of the two motions at this offset, at most 1
  /// Fraction of the true path's variance that the estimate does not explain at this offset, [0, 1]
  /// ...
  double unexplained = 1;
  double runner_up = 1;  ///< ... and at the next best one; a repetitive drive has several good ones

  /// Whether the paths agree at this offset, and much less at any other.
  [[nodiscard]] bool IsReliable() const;
};

/// Finds the offset of the clocks from the motion of the robot: speed and yaw rate do not depend on
/// the frames, and their correlation does not depend on a scale. They are resampled on a common
/// grid and correlated at all shifts at once; parts where either has no poses are excluded. Near
/// each of the best shifts the offset is refined to the least squared error of position and yaw
/// after a planar similarity; the offset with the least error is returned.
/// @param truth, estimate  Stamps strictly increasing.
/// @return unset when the trajectories have too few poses, or when their motion does not determine
///   the offset.
/// Cost: n log n, about 0.2 s and 60 MB at most.
std::optional<TimeOffset> FindTimeOffset(const std::vector<StampedPose>& truth,
                                         const std::vector<StampedPose>& estimate);

/// The same poses with all stamps increased by offset_s.
std::vector<StampedPose> Delayed(std::vector<StampedPose> poses, double offset_s);

}  // namespace ceilmap::evaluation
