#include "app/evaluation/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ceilmap::evaluation {

using calib::Pose2;

std::vector<std::pair<std::size_t, std::size_t>> MatchStamps(
    const std::vector<StampedPose>& truth,
    const std::vector<StampedPose>& estimate,
    double max_dt_s) {
  struct Candidate {
    double dt_s = 0;
    std::size_t truth = 0;
  };
  std::vector<std::optional<Candidate>> best(estimate.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const auto later = std::lower_bound(
        estimate.begin(), estimate.end(), truth[k].stamp_s, [](const StampedPose& pose, double t) {
          return pose.stamp_s < t;
        });
    const auto j = static_cast<std::size_t>(later - estimate.begin());
    for (const std::size_t c : {j - 1, j}) {  // j - 1 of 0 is out of range as well
      if (c >= estimate.size()) continue;
      const double dt_s = std::abs(estimate[c].stamp_s - truth[k].stamp_s);
      if (dt_s <= max_dt_s && (!best[c] || dt_s < best[c]->dt_s)) best[c] = Candidate{dt_s, k};
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t c = 0; c < best.size(); ++c) {
    if (best[c]) pairs.emplace_back(best[c]->truth, c);
  }
  std::sort(pairs.begin(), pairs.end());
  const auto same_truth = [](const auto& a, const auto& b) { return a.first == b.first; };
  pairs.erase(std::unique(pairs.begin(), pairs.end(), same_truth), pairs.end());
  return pairs;
}

std::vector<double> PathLengths(const std::vector<StampedPose>& poses) {
  std::vector<double> lengths(poses.size(), 0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector2d step = (poses[i].position - poses[i - 1].position).head<2>();
    lengths[i] = lengths[i - 1] + step.norm();
  }
  return lengths;
}

Pose2 FitPlanarMotion(const std::vector<PointPair>& pairs) {
  Eigen::Vector2d mean_truth = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_estimate = Eigen::Vector2d::Zero();
  for (const PointPair& pair : pairs) {
    mean_truth += pair.truth;
    mean_estimate += pair.estimate;
  }
  mean_truth /= static_cast<double>(pairs.size());
  mean_estimate /= static_cast<double>(pairs.size());
  double cross = 0;
  double dot = 0;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector2d s = pair.estimate - mean_estimate;
    const Eigen::Vector2d d = pair.truth - mean_truth;
    cross += s.x() * d.y() - s.y() * d.x();
    dot += s.dot(d);
  }
  Pose2 T{0, 0, std::atan2(cross, dot)};
  const Eigen::Vector2d t = mean_truth - T.Rotation() * mean_estimate;
  T.x = t.x();
  T.y = t.y();
  return T;
}

}  // namespace ceilmap::evaluation
