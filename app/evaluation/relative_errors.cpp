#include "app/evaluation/relative_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calib/base/degrees.hpp"

namespace ceilmap::evaluation {
namespace {

constexpr double kToleranceOfDelta = 0.1;

// Distance in space to each pose from the previous one; 0 for the first pose.
std::vector<double> StepsInSpace(const std::vector<PosePair>& poses, bool of_truth) {
  const auto position = [&](std::size_t i) -> const Eigen::Vector3d& {
    return of_truth ? poses[i].truth.position : poses[i].estimate.position;
  };
  std::vector<double> steps_m(poses.size(), 0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    steps_m[i] = (position(i) - position(i - 1)).norm();
  }
  return steps_m;
}

IndexPairs PairsByFrames(std::size_t count, std::size_t delta, bool all_pairs) {
  IndexPairs pairs;
  const std::size_t step = all_pairs ? 1 : delta;
  for (std::size_t i = 0; i + delta < count; i += step) pairs.emplace_back(i, i + delta);
  return pairs;
}

IndexPairs ConsecutivePairs(const std::vector<double>& steps_m, double delta_m) {
  IndexPairs pairs;
  std::optional<std::size_t> last;
  double since_last_m = 0;  // summed anew for each motion, as in evo: rounding determines its end
  for (std::size_t i = 0; i < steps_m.size(); ++i) {
    since_last_m += steps_m[i];
    if (since_last_m < delta_m) continue;
    if (last) pairs.emplace_back(*last, i);
    last = i;
    since_last_m = 0;
  }
  return pairs;
}

// The first of the poses after i whose distance from i is nearest to delta.
std::size_t NearestTo(const std::vector<double>& distance_m, std::size_t i, double delta_m) {
  const auto begin = distance_m.begin() + static_cast<std::ptrdiff_t>(i) + 1;
  auto nearest = std::lower_bound(begin, distance_m.end(), distance_m[i] + delta_m);
  const auto off_m = [&](auto at) { return std::abs(*at - distance_m[i] - delta_m); };
  if (nearest == distance_m.end() || (nearest != begin && off_m(nearest - 1) <= off_m(nearest))) {
    nearest = std::lower_bound(begin, nearest, *(nearest - 1));  // the robot may have stood still
                                                                 // there
  }
  return static_cast<std::size_t>(nearest - distance_m.begin());
}

IndexPairs AllPairs(const std::vector<double>& steps_m, double delta_m) {
  std::vector<double> distance_m(steps_m.size());
  std::partial_sum(steps_m.begin(), steps_m.end(), distance_m.begin());
  IndexPairs pairs;
  for (std::size_t i = 0; i + 1 < distance_m.size(); ++i) {
    const std::size_t j = NearestTo(distance_m, i, delta_m);
    const double off_m = std::abs(distance_m[j] - distance_m[i] - delta_m);
    if (off_m <= kToleranceOfDelta * delta_m) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace

IndexPairs SelectPairs(const std::vector<PosePair>& poses, const RelativeParams& params) {
  if (params.unit == DeltaUnit::kFrames) {
    const auto delta = static_cast<std::size_t>(std::max(1.0, params.delta));
    return PairsByFrames(poses.size(), delta, params.all_pairs);
  }
  const std::vector<double> steps_m = StepsInSpace(poses, params.path_of_truth);
  return params.all_pairs ? AllPairs(steps_m, params.delta)
                          : ConsecutivePairs(steps_m, params.delta);
}

std::optional<PoseErrorStatistics> RelativeErrors(const std::vector<PosePair>& poses,
                                                  const RelativeParams& params) {
  std::vector<PoseError> errors;
  for (const auto& [i, j] : SelectPairs(poses, params)) {
    errors.push_back(RelativeError(poses[i], poses[j]));
  }
  if (errors.empty()) return std::nullopt;
  return Statistics(errors);
}

std::vector<SegmentErrors> MeasureSegments(const std::vector<PosePair>& poses,
                                           const std::vector<double>& distance_m,
                                           const SegmentParams& params) {
  std::vector<SegmentErrors> segments;
  for (const double length_m : params.lengths_m) {
    std::vector<double> translation_percent;
    std::vector<double> rotation_deg_per_m;
    for (std::size_t i = 0; i < poses.size(); i += params.every) {
      const auto end =
          std::lower_bound(distance_m.begin(), distance_m.end(), distance_m[i] + length_m);
      if (end == distance_m.end()) break;
      const auto j = static_cast<std::size_t>(end - distance_m.begin());
      const PoseError error = RelativeError(poses[i], poses[j]);
      translation_percent.push_back(100 * error.translation_m / length_m);
      rotation_deg_per_m.push_back(kDegPerRad * error.angle_rad / length_m);
    }
    if (translation_percent.empty()) continue;
    segments.push_back({length_m,
                        Statistics(std::move(translation_percent)),
                        Statistics(std::move(rotation_deg_per_m))});
  }
  return segments;
}

}  // namespace ceilmap::evaluation
