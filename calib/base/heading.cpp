#include "calib/base/heading.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/pose2.hpp"

namespace ceilmap {

HeadingTurn TurnBetween(const HeadingPrior& from,
                        const HeadingPrior& to,
                        double common_rad2,
                        double single_rad) {
  return {WrapAngle(to.heading_rad - from.heading_rad),
          from.variance_rad2 + to.variance_rad2 - 2 * common_rad2 + 2 * single_rad * single_rad};
}

void HeadingSince::Add(const HeadingPrior& heading) {
  now_ = heading;
  common_rad2_ = std::min(common_rad2_, heading.variance_rad2);
  min_rad2_ = std::min(min_rad2_.value_or(heading.variance_rad2), heading.variance_rad2);
}

void HeadingSince::Mark() {
  marked_ = now_;
  if (marked_) common_rad2_ = marked_->variance_rad2;
}

std::optional<HeadingTurn> HeadingSince::Turn() const {
  if (!marked_) return std::nullopt;
  const double single_rad = std::max(noise_rad_, std::sqrt(*min_rad2_));
  return TurnBetween(*marked_, *now_, common_rad2_, single_rad);
}

}  // namespace ceilmap
