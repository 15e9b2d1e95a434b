#include "mapping/match_gate.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace ceilmap::mapping {

MatchQuality QualityOf(const registration::Registration& registration,
                       const registration::Dissimilarity& dissimilarity) {
  return {static_cast<double>(registration.inliers) / std::max(registration.blocks, 1),
          registration.peak,
          dissimilarity.mean};
}

MatchQuality Median(std::vector<MatchQuality> matches) {
  MatchQuality median;
  if (matches.empty()) return median;
  const auto middle = matches.begin() + static_cast<std::ptrdiff_t>(matches.size() / 2);
  for (double MatchQuality::*const field :
       {&MatchQuality::inlier_ratio, &MatchQuality::peak, &MatchQuality::dissimilarity}) {
    std::nth_element(
        matches.begin(),
        middle,
        matches.end(),
        [field](const MatchQuality& x, const MatchQuality& y) { return x.*field < y.*field; });
    median.*field = (*middle).*field;
  }
  return median;
}

void MatchGate::Add(const MatchQuality& right) {
  right_.push_back(right);
  if (static_cast<int>(right_.size()) > params_.remembered) right_.pop_front();
}

bool MatchGate::Accepts(const MatchQuality& match) const {
  // Typical of true matches at one exposure; used until a correct match is known.
  MatchQuality typical{1.0, 0.65, params_.max_dissimilarity / params_.max_dissimilarity_ratio};
  if (!right_.empty()) {
    const double most = typical.dissimilarity;
    typical = Median({right_.begin(), right_.end()});
    typical.dissimilarity = std::min(typical.dissimilarity, most);
  }
  return match.inlier_ratio >= params_.min_inlier_ratio * typical.inlier_ratio &&
         match.peak >= params_.min_peak_ratio * typical.peak &&
         match.dissimilarity <= params_.max_dissimilarity_ratio * typical.dissimilarity;
}

}  // namespace ceilmap::mapping
