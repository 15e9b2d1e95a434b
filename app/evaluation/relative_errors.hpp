#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "app/evaluation/pose_errors.hpp"

namespace ceilmap::evaluation {

/// Errors of the motion between two poses of one trajectory: they tell how an estimate drifts, and
/// no alignment changes them but for its scale.

/// Positions (from, to) in a list of matched poses, from < to.
using IndexPairs = std::vector<std::pair<std::size_t, std::size_t>>;

enum class DeltaUnit {
  kFrames,  ///< matched poses
  kMetres,  ///< along the path in space
};

/// Which motions evo compares.
struct RelativeParams {
  double delta = 1;  ///< how far `to` is from `from`; > 0, whole with kFrames
  DeltaUnit unit = DeltaUnit::kFrames;
  /// From every pose, to the one whose distance is nearest to delta, within a tenth of it; else one
  /// motion ends where the next begins, as soon as delta is reached, and, with kMetres, the first
  /// begins where delta is reached for the first time.
  bool all_pairs = false;
  /// Whose path is measured with kMetres: evo's default is the estimate's.
  bool path_of_truth = false;
};

/// The motions by those rules. Cost: n, with all_pairs n log n.
IndexPairs SelectPairs(const std::vector<PosePair>& poses, const RelativeParams& params);

/// Relative pose errors.
/// @return unset when no motion is that long.
std::optional<PoseErrorStatistics> RelativeErrors(const std::vector<PosePair>& poses,
                                                  const RelativeParams& params);

/// Errors of the motion over one distance, per distance, as the KITTI odometry benchmark has them
/// (Geiger et al. 2012, "Are we ready for autonomous driving?").
struct SegmentErrors {
  double length_m = 0;
  ErrorStatistics translation_percent;
  ErrorStatistics rotation_deg_per_m;
};

struct SegmentParams {
  std::vector<double> lengths_m = {1, 2, 5, 10};  ///< each > 0
  std::size_t every = 1;                          ///< a segment starts at every so many poses, >= 1
};

/// A segment ends at the first pose that is at least its length away along the true path.
/// @param way_m  of each pose along the true path, never falling.
/// @return one for each length that fits into the path, in the order of the lengths.
std::vector<SegmentErrors> MeasureSegments(const std::vector<PosePair>& poses,
                                           const std::vector<double>& way_m,
                                           const SegmentParams& params = {});

}  // namespace ceilmap::evaluation
