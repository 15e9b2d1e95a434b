#include "localization/map_shape.hpp"

#include <algorithm>

#include "mapping/map_graph.hpp"
#include "mapping/pose_graph.hpp"

namespace ceilmap::localization {

MapShape::MapShape(const mapping::MapReader& map)
    : computing_(std::async(std::launch::async, [&map] { return Compute(map); })) {}

std::vector<MapShape::Place> MapShape::Compute(const mapping::MapReader& map) {
  const mapping::MapGraph graph = map.ReadGraph();
  std::vector<Place> places;
  if (graph.keyframes.size() < 2 || graph.edges.empty()) return places;
  const std::vector<Eigen::Matrix3d> covariances =
      mapping::ShapeCovariances(graph.edges, graph.keyframes.front().id, mapping::PosesById(graph));
  // Without a loop the edges cannot disagree, and are taken at their word.
  const double disagreement = graph.quality.chi2_per_dof;
  const double factor = disagreement > 0 ? disagreement : 1;
  for (const mapping::Keyframe& keyframe : graph.keyframes) {
    const auto id = static_cast<std::size_t>(keyframe.id);
    if (id >= covariances.size() || !covariances[id].allFinite()) continue;
    places.push_back({keyframe.pose.T_map_base.Translation(), factor * covariances[id]});
  }
  return places;
}

Eigen::Matrix3d MapShape::At(const calib::Pose2& T_map_base) {
  if (computing_.valid()) places_ = computing_.get();
  if (places_.empty()) return Eigen::Matrix3d::Zero();
  const Eigen::Vector2d at = T_map_base.Translation();
  const auto nearest =
      std::min_element(places_.begin(), places_.end(), [&](const Place& a, const Place& b) {
        return (a.position - at).squaredNorm() < (b.position - at).squaredNorm();
      });
  return nearest->covariance;
}

}  // namespace ceilmap::localization
