#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "app/evaluation/pose_errors.hpp"

namespace ceilmap::evaluation {

/// Errors of the motion between two poses of one trajectory. They show the drift of an estimate and
/// do not depend on the alignment except for its scale.

/// Index pairs (from, to) in a list of matched poses, from < to.
using IndexPairs = std::vector<std::pair<std::size_t, std::size_t>>;

enum class DeltaUnit {
  kFrames,  ///< matched poses
  kMetres,  ///< along the path in space
};

/// Selection of the motions that evo compares.
struct RelativeParams {
  double delta = 1;  ///< distance from `from` to `to`; > 0, whole with kFrames
  DeltaUnit unit = DeltaUnit::kFrames;
  /// True: one motion from every pose, to the pose whose distance is nearest to delta, within a
  /// tenth of it. False: consecutive motions; each ends as soon as delta is reached, where the next
  /// one begins. With kMetres, the first one begins where delta is reached for the first time.
  bool all_pairs = false;
  /// With kMetres: true to measure the path of the truth, false to measure that of the estimate
  /// (the default of evo).
  bool path_of_truth = false;
};

/// Selects the motions by these rules. Cost: n, with all_pairs n log n.
IndexPairs SelectPairs(const std::vector<PosePair>& poses, const RelativeParams& params);

/// Relative pose errors.
/// @return unset when no motion has the required length.
std::optional<PoseErrorStatistics> RelativeErrors(const std::vector<PosePair>& poses,
                                                  const RelativeParams& params);

/// Errors of the motion over one distance, divided by the distance, as in the KITTI odometry
/// benchmark (Geiger et al. 2012, "Are we ready for autonomous driving?").
struct SegmentErrors {
  double length_m = 0;
  ErrorStatistics translation_percent;
  ErrorStatistics rotation_deg_per_m;
};

struct SegmentParams {
  std::vector<double> lengths_m = {1, 2, 5, 10};  ///< each > 0
  std::size_t every = 1;                          ///< a segment starts at every n-th pose, >= 1
};

/// Measures segments. A segment ends at the first pose that is at least its length away along the
/// true path.
/// @param distance_m  Distance of each pose along the true path, never decreasing.
/// @return one for each length that fits into the path, in the order of the lengths.
std::vector<SegmentErrors> MeasureSegments(const std::vector<PosePair>& poses,
                                           const std::vector<double>& distance_m,
                                           const SegmentParams& params = {});

}  // namespace ceilmap::evaluation
