#pragma once

#include <optional>
#include <vector>

#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// How far two clocks are apart that saw the same drive.
struct TimeOffset {
  double offset_s = 0;  ///< stamp of the truth = stamp of the estimate + offset_s
  /// Standard deviation of offset_s as the remaining errors have it, as if each were independent.
  double sigma_s = 0;
  double correlation = 0;  ///< of the two motions at this offset, at most 1
  /// Part of the true path's variance that the estimate leaves open at this offset, in [0, 1] ...
  double unexplained = 1;
  double runner_up = 1;  ///< ... and at the next best one; a drive that repeats itself has many

  /// The paths agree, and nowhere else nearly so.
  [[nodiscard]] bool IsSure() const;
};

struct TimeOffsetParams {
  double lever_m = 0.5;   ///< what a radian of yaw weighs beside metres, > 0
  double window_s = 0.2;  ///< over which speeds are measured, at least two poses apart; >= 0
  /// Part of the shorter trajectory that must overlap the other one, in (0, 1].
  double min_overlap = 0.3;
};

/// Finds the offset of the clocks from how the robot moved: speed and yaw rate do not depend on the
/// frames, nor their correlation on a scale. They are resampled on a common grid and correlated at
/// all shifts at once (parts where either has no poses are left out). Beside each of the best ones
/// the offset is taken that leaves the least squared error of position and yaw after a planar
/// similarity, and of these the one that leaves least.
/// @param truth, estimate  stamps strictly increasing.
/// @return unset when the trajectories have too few poses, or do not move in any way that tells.
/// Cost: n log n, some 0.2 s and 60 MB at most.
std::optional<TimeOffset> FindTimeOffset(const std::vector<StampedPose>& truth,
                                         const std::vector<StampedPose>& estimate,
                                         const TimeOffsetParams& params = {});

/// The same poses by another clock.
std::vector<StampedPose> Delayed(std::vector<StampedPose> poses, double offset_s);

}  // namespace ceilmap::evaluation
