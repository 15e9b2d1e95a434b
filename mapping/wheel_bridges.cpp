#include "mapping/wheel_bridges.hpp"

#include <cmath>

#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {

void WheelBridges::Follow(bool placed,
                          const std::vector<graph::Edge>& edges,
                          const std::optional<wheels::RelativeMotion>& motion) {
  since_placed_ = wheels::Joined(since_placed_, motion);
  for (const graph::Edge& edge : edges) {
    if (edge.kind == graph::Edge::Kind::kWheels && since_placed_) ways_[edge.to] = *since_placed_;
  }
  if (placed) since_placed_ = wheels::RelativeMotion{};
}

void WheelBridges::Correct(std::vector<graph::Edge>& edges) const {
  if (forgotten_) {
    std::erase_if(edges,
                  [](const graph::Edge& edge) { return edge.kind == graph::Edge::Kind::kWheels; });
    return;
  }
  for (graph::Edge& edge : edges) {
    const auto found = ways_.find(edge.to);
    if (edge.kind != graph::Edge::Kind::kWheels || found == ways_.end()) continue;
    const wheels::RelativeMotion& way = found->second;
    const double unknown_m2 = slips_.Variance(way.travel_m) - way.slips.Variance(way.travel_m);
    if (unknown_m2 > 0) InflateCovariance(std::sqrt(unknown_m2), 0, edge);
  }
}

}  // namespace ceilmap::mapping
