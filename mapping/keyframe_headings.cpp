#include "mapping/keyframe_headings.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/pose2.hpp"

namespace ceilmap::mapping {

void KeyframeHeadings::Add(std::int64_t id, const HeadingPrior& heading) {
  const auto index = static_cast<std::size_t>(id);
  if (index >= headings_.size()) headings_.resize(index + 1);
  headings_[index] = heading;
  min_rad2_ = std::min(min_rad2_.value_or(heading.variance_rad2), heading.variance_rad2);
}

std::optional<HeadingTurn> KeyframeHeadings::Turn(std::int64_t from, std::int64_t to) const {
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
  const double single_rad = std::max(trust_.noise_rad, std::sqrt(*min_rad2_));
  return TurnBetween(*at_from, *at_to, common, single_rad);
}

graph::KeyframeGraph::Relative KeyframeHeadings::Narrowed(
    const graph::KeyframeGraph::Relative& by_graph, std::int64_t from, std::int64_t to) const {
  const auto turn = Turn(from, to);
  const Pose2& T = by_graph.T_from_to;
  const double variance = by_graph.covariance(2, 2);
  if (!turn || mapping::Contradict(*turn, {T.yaw, variance}, trust_)) return by_graph;
  // The update of a Kalman filter by a measured yaw.
  const Eigen::Vector3d gain = by_graph.covariance.col(2) / (variance + turn->variance_rad2);
  const Eigen::Vector3d moved = gain * WrapAngle(turn->turn_rad - T.yaw);
  return {{T.x + moved.x(), T.y + moved.y(), WrapAngle(T.yaw + moved.z())},
          by_graph.covariance - gain * by_graph.covariance.row(2)};
}

bool KeyframeHeadings::Contradict(const graph::Edge& edge) const {
  const auto turn = Turn(edge.from, edge.to);
  return turn && mapping::Contradict(*turn, {edge.T_from_to.yaw, 0}, trust_);
}

}  // namespace ceilmap::mapping
