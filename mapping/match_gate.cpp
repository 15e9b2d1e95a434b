#include "mapping/match_gate.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace ceilmap::mapping {

namespace {

// Relative to the median of the correct matches.
constexpr double kMinTypicalInliers = 0.93;
constexpr double kMinPeakRatio = 0.87;
constexpr double kMaxDissimilarityRatio = 1.25;
// Absolute upper limit, whatever the median is. The only limit on dissimilarity as long as no
// correct match is known.
constexpr double kMaxDissimilarity = 1.6;

}  // namespace

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
  if (static_cast<int>(right_.size()) > remembered_) right_.pop_front();
}

bool MatchGate::Accepts(const MatchQuality& match) const {
  // Typical of true matches at one exposure; used until a correct match is known.
  MatchQuality typical{1.0, 0.65, kMaxDissimilarity / kMaxDissimilarityRatio};
  if (!right_.empty()) {
    const double most = typical.dissimilarity;
    typical = Median({right_.begin(), right_.end()});
    typical.dissimilarity = std::min(typical.dissimilarity, most);
  }
  return match.inlier_ratio >= kMinTypicalInliers * typical.inlier_ratio &&
         match.peak >= kMinPeakRatio * typical.peak &&
         match.dissimilarity <= kMaxDissimilarityRatio * typical.dissimilarity;
}

}  // namespace ceilmap::mapping
