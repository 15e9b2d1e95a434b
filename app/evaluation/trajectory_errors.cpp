#include "app/evaluation/trajectory_errors.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "app/evaluation/alignment.hpp"
#include "calib/pose2.hpp"

namespace ceilmap::evaluation {
namespace {

using calib::Pose2;
using calib::WrapAngle;

constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr double kRelativeLengthM = 1;

// A planar pose of the truth beside the estimate's at the same time.
struct PosePair {
  Pose2 truth;
  Pose2 estimate;
  double distance_m = 0;  // along the true path from its start
};

Pose2 Planar(const StampedPose& pose) {
  return {pose.position.x(), pose.position.y(), YawOf(pose)};
}

Pose2 FitSe2(const std::vector<PosePair>& pairs) {
  std::vector<PointPair> points;
  points.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    points.push_back({pair.truth.Translation(), pair.estimate.Translation()});
  }
  return FitPlanarMotion(points);
}

Pose2 Align(const std::vector<PosePair>& pairs, Alignment align) {
  switch (align) {
    case Alignment::kSe2:
      return FitSe2(pairs);
    case Alignment::kFirst:
      return pairs.front().truth * pairs.front().estimate.Inverse();
    case Alignment::kNone:
      break;
  }
  return {};
}

void AddRelativeErrors(const std::vector<PosePair>& pairs, TrajectoryErrors& errors) {
  std::vector<double> position_m;
  std::vector<double> yaw_deg;
  for (const PosePair& from : pairs) {
    const auto to = std::lower_bound(
        pairs.begin(),
        pairs.end(),
        from.distance_m + kRelativeLengthM,
        [](const PosePair& pair, double distance_m) { return pair.distance_m < distance_m; });
    if (to == pairs.end()) break;
    const Pose2 true_motion = from.truth.Inverse() * to->truth;
    const Pose2 motion = from.estimate.Inverse() * to->estimate;
    position_m.push_back((motion.Translation() - true_motion.Translation()).norm());
    yaw_deg.push_back(WrapAngle(motion.yaw - true_motion.yaw) * kDegPerRad);
  }
  if (position_m.empty()) return;
  errors.per_metre_m = Statistics(std::move(position_m));
  errors.per_metre_yaw_deg = Statistics(std::move(yaw_deg));
}

// Value at a fractional rank of sorted values, as numpy.percentile has it.
double AtRank(const std::vector<double>& sorted, double part) {
  const double rank = part * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (sorted[above] - sorted[below]) * (rank - static_cast<double>(below));
}

}  // namespace

ErrorStatistics Statistics(std::vector<double> errors) {
  for (double& error : errors) error = std::abs(error);
  std::sort(errors.begin(), errors.end());
  const auto count = static_cast<double>(errors.size());
  const double sum = std::accumulate(errors.begin(), errors.end(), 0.0);
  const double squares = std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0);
  return {std::sqrt(squares / count),
          sum / count,
          AtRank(errors, 0.5),
          AtRank(errors, 0.95),
          errors.back()};
}

std::optional<TrajectoryErrors> EvaluateTrajectory(const std::vector<StampedPose>& truth,
                                                   const std::vector<StampedPose>& estimate,
                                                   const EvaluationParams& params) {
  const std::vector<double> distances_m = PathLengths(truth);
  std::vector<PosePair> pairs;
  for (const auto& [k, c] : MatchStamps(truth, estimate, params.max_dt_s)) {
    pairs.push_back({Planar(truth[k]), Planar(estimate[c]), distances_m[k]});
  }
  if (pairs.empty()) return std::nullopt;

  const Pose2 T_truth_estimate = Align(pairs, params.align);
  std::vector<double> position_m;
  std::vector<double> yaw_deg;
  for (const PosePair& pair : pairs) {
    const Pose2 aligned = T_truth_estimate * pair.estimate;
    position_m.push_back((aligned.Translation() - pair.truth.Translation()).norm());
    yaw_deg.push_back(WrapAngle(aligned.yaw - pair.truth.yaw) * kDegPerRad);
  }
  TrajectoryErrors errors;
  errors.matched = static_cast<std::int64_t>(pairs.size());
  errors.expected = static_cast<std::int64_t>(truth.size());
  errors.path_m = distances_m.back();
  errors.position_m = Statistics(std::move(position_m));
  errors.yaw_deg = Statistics(std::move(yaw_deg));
  AddRelativeErrors(pairs, errors);
  return errors;
}

}  // namespace ceilmap::evaluation
