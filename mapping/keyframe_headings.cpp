#include "mapping/keyframe_headings.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::mapping {

void KeyframeHeadings::Add(std::int64_t id, const calib::HeadingPrior& heading) {
  const auto index = static_cast<std::size_t>(id);
  if (index >= headings_.size()) headings_.resize(index + 1);
  headings_[index] = heading;
  least_rad2_ = std::min(least_rad2_.value_or(heading.variance_rad2), heading.variance_rad2);
}

std::optional<calib::HeadingTurn> KeyframeHeadings::Turn(std::int64_t from, std::int64_t to) const {
  const auto [first, last] = std::minmax(from, to);
  if (first < 0 || last >= static_cast<std::int64_t>(headings_.size())) return std::nullopt;
  const auto& at_from = headings_[static_cast<std::size_t>(from)];
  const auto& at_to = headings_[static_cast<std::size_t>(to)];
  if (!at_from || !at_to) return std::nullopt;
  double common = at_from->variance_rad2;
  for (std::int64_t id = first; id <= last; ++id) {
    const auto& between = headings_[static_cast<std::size_t>(id)];
    if (between) common = std::min(common, between->variance_rad2);
  }
  const double single_rad = std::max(noise_rad_, std::sqrt(*least_rad2_));
  return calib::TurnBetween(*at_from, *at_to, common, single_rad);
}

}  // namespace ceilmap::mapping
