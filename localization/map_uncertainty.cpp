#include "localization/map_uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/graph/map_graph.hpp"
#include "mapping/graph/pose_graph.hpp"

namespace ceilmap::localization {

namespace {

/// Factor for the covariances of edges that disagree more than the covariances imply. Never less
/// than 1: errors common to all edges (the camera's calibration, the light) do not show in their
/// disagreement.
double ClaimFactor(const graph::MapQuality& quality) {
  return std::max(1.0, quality.chi2_per_dof);
}

}  // namespace

MapUncertainty::MapUncertainty(const store::MapReader& map)
    : computing_(std::async(std::launch::async, [&map] { return Compute(map); })) {}

std::vector<MapUncertainty::Place> MapUncertainty::Compute(const store::MapReader& map) {
  graph::MapGraph graph;
  graph.keyframes = map.ReadKeyframes();
  graph.edges = map.ReadEdges();
  std::vector<Place> places;
  if (graph.keyframes.size() < 2 || graph.edges.empty()) return places;
  const double factor = ClaimFactor(map.Quality());
  graph::PoseGraphParams params;
  params.loop_loss_scale *= std::sqrt(factor);  // as in the optimisation of the map
  const std::vector<Eigen::Matrix3d> covariances = graph::GaugeFreeCovariances(
      graph.edges, graph.keyframes.front().id, graph::PosesById(graph), params);
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    const auto id = static_cast<std::size_t>(keyframe.id);
    if (id >= covariances.size() || !covariances[id].allFinite()) continue;
    places.push_back({keyframe.pose.T_map_base.Translation(), factor * covariances[id]});
  }
  return places;
}

Eigen::Matrix3d MapUncertainty::At(const Pose2& T_map_base) {
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
