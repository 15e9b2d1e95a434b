#include "app/evaluation/association.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ceilmap::evaluation {

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
    for (const std::size_t c : {j - 1, j}) {  // for j = 0, j - 1 is out of range as well
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

}  // namespace ceilmap::evaluation
