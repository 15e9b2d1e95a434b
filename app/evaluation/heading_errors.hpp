#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "app/evaluation/statistics.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {
/// A heading that was measured: counter-clockwise seen from above, from any direction.
struct StampedHeading {
  double stamp_s = 0;
  double heading_rad = 0;
};

/// How the robot of a trajectory is turned.
std::vector<StampedHeading> HeadingsOf(const std::vector<StampedPose>& poses);

/// One of them against the truth.
struct HeadingError {
  std::size_t heading = 0;  ///< which one
  std::size_t truth = 0;    ///< which true pose
  double true_deg = 0;      ///< counted as the headings are, continuous over full turns
  double error_deg = 0;     ///< heading less truth, continuous over full turns (kFirst)
  double way_m = 0;         ///< along the true path, from its first pose
};

/// What headings are counted from.
enum class HeadingZero {
  kFirst,  ///< any direction: the first heading that has a true pose is taken as right
  kTruth,  ///< the x axis of the truth: errors are in (-180, 180] deg, never continued beyond
};

/// Errors of headings.
struct HeadingErrors {
  std::vector<HeadingError> of;  ///< those with a true pose, at least one
  double coverage = 0;           ///< part of the true poses that has a heading
  double path_m = 0;             ///< from the first to the last of them
  double seconds = 0;
  double turned_deg = 0;  ///< sum of the true turns, whichever way
  ErrorStatistics error_deg;
  double signed_mean_deg = 0;
  double std_deg = 0;
  double end_deg = 0;  ///< the last error
  /// Slopes of the lines with the least squared distance from the errors: over the way, where it
  /// is longer than half a metre, and over time, where there is more than one moment.
  std::optional<double> drift_deg_per_m;
  std::optional<double> drift_deg_per_s;
};

/// @param headings, truth  stamps strictly increasing, at least one each.
/// @return unset when no two are within max_dt_s of each other.
std::optional<HeadingErrors> CompareHeadings(const std::vector<StampedHeading>& headings,
                                             const std::vector<StampedPose>& truth,
                                             double max_dt_s,
                                             HeadingZero zero = HeadingZero::kFirst);

}  // namespace ceilmap::evaluation
