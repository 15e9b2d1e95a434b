#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "app/evaluation/statistics.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {
/// A measured heading: counter-clockwise seen from above, from an arbitrary direction.
struct StampedHeading {
  double stamp_s = 0;
  double heading_rad = 0;
};

/// Headings of the poses of a trajectory.
std::vector<StampedHeading> HeadingsOf(const std::vector<StampedPose>& poses);

/// Error of one heading.
struct HeadingError {
  std::size_t heading = 0;  ///< index of the heading
  std::size_t truth = 0;    ///< index of the true pose
  double true_deg = 0;      ///< from the same zero as the headings, continuous over full turns
  double error_deg = 0;     ///< heading minus truth, continuous over full turns (kFirst)
  double distance_m = 0;    ///< distance along the true path from its first pose
};

/// Zero direction of headings.
enum class HeadingZero {
  kFirst,  ///< arbitrary: the first heading with a true pose is taken as correct
  kTruth,  ///< the x axis of the truth: errors are in (-180, 180] deg, not continued beyond
};

/// Errors of headings.
struct HeadingErrors {
  std::vector<HeadingError> of;  ///< headings with a true pose, at least one
  double coverage = 0;           ///< fraction of the true poses that have a heading
  double path_m = 0;             ///< length of the true path from the first to the last of them
  double seconds = 0;
  double turned_deg = 0;  ///< sum of the absolute true turns
  ErrorStatistics error_deg;
  double signed_mean_deg = 0;
  double std_deg = 0;
  double end_deg = 0;  ///< the last error
  /// Slopes of the lines through the errors by robust regression (RobustSlope), as in Labrosse
  /// 2006, Table 3: over the distance travelled, where it is longer than half a metre, and over
  /// time, where there is more than one stamp.
  std::optional<double> drift_deg_per_m;
  std::optional<double> drift_deg_per_s;
};

/// @param headings, truth  Stamps strictly increasing, at least one each.
/// @return unset when no heading is within max_dt_s of a true pose.
std::optional<HeadingErrors> CompareHeadings(const std::vector<StampedHeading>& headings,
                                             const std::vector<StampedPose>& truth,
                                             double max_dt_s,
                                             HeadingZero zero = HeadingZero::kFirst);

}  // namespace ceilmap::evaluation
