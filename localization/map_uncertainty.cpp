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

/// Covariance of positions by the scale that the edges of a ceiling with depth have in common: it
/// is that of the heights, which differ between rooms in how well they show the reference plane.
/// Maps of a hall and of four rooms were up to 0.4 % too long or too short.
class CommonScale {
 public:
  explicit CommonScale(const std::vector<graph::Keyframe>& keyframes) {
    bool depth = false;
    for (const graph::Keyframe& keyframe : keyframes) {
      centre_ += keyframe.pose.T_map_base.Translation() / static_cast<double>(keyframes.size());
      depth = depth || keyframe.heights != nullptr;
    }
    constexpr double kSigma = 0.002;
    if (depth) variance_ = kSigma * kSigma;
  }

  [[nodiscard]] Eigen::Matrix2d At(const Eigen::Vector2d& position) const {
    const Eigen::Vector2d from_centre = position - centre_;
    return variance_ * from_centre * from_centre.transpose();
  }

 private:
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  double variance_ = 0;
};

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
  const CommonScale scale(graph.keyframes);
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    const auto id = static_cast<std::size_t>(keyframe.id);
    if (id >= covariances.size() || !covariances[id].allFinite()) continue;
    const Eigen::Vector2d position = keyframe.pose.T_map_base.Translation();
    Eigen::Matrix3d covariance = factor * covariances[id];
    covariance.topLeftCorner<2, 2>() += scale.At(position);
    places.push_back({position, covariance});
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
