#include "mapping/match_standard.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace ceilmap::mapping {

MatchQuality QualityOf(const registration::Registration& registration,
                       const registration::Dissimilarity& unlike) {
  return {static_cast<double>(registration.inliers) / std::max(registration.blocks, 1),
          registration.peak,
          unlike.mean};
}

MatchQuality Median(std::vector<MatchQuality> matches) {
  MatchQuality median;
  if (matches.empty()) return median;
  const auto middle = matches.begin() + static_cast<std::ptrdiff_t>(matches.size() / 2);
  for (double MatchQuality::*const field :
       {&MatchQuality::inlier_part, &MatchQuality::peak, &MatchQuality::unlike}) {
    std::nth_element(
        matches.begin(),
        middle,
        matches.end(),
        [field](const MatchQuality& x, const MatchQuality& y) { return x.*field < y.*field; });
    median.*field = (*middle).*field;
  }
  return median;
}

void MatchStandard::Add(const MatchQuality& right) {
  right_.push_back(right);
  if (static_cast<int>(right_.size()) > params_.remembered) right_.pop_front();
}

bool MatchStandard::Meets(const MatchQuality& match) const {
  // What true matches have in simulated rooms at one exposure; the median peak there is 0.73.
  MatchQuality typical{1.0, 0.65, params_.max_unlike / params_.max_unlike_part};
  if (!right_.empty()) {
    const double most = typical.unlike;
    typical = Median({right_.begin(), right_.end()});
    typical.unlike = std::min(typical.unlike, most);
  }
  return match.inlier_part >= params_.min_inlier_part * typical.inlier_part &&
         match.peak >= params_.min_peak_part * typical.peak &&
         match.unlike <= params_.max_unlike_part * typical.unlike;
}

}  // namespace ceilmap::mapping
