#include "mapping/graph/control_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "calib/base/error.hpp"
#include "calib/base/statistics.hpp"
#include "mapping/graph/frame_ties.hpp"
#include "mapping/graph/optimized_graph.hpp"

namespace ceilmap::graph {
namespace {

void CheckMeasurements(const MapGraph& graph, std::span<const ControlMeasurement> measurements) {
  std::unordered_set<std::int64_t> known;
  for (const Keyframe& keyframe : graph.keyframes) known.insert(keyframe.id);
  for (const ControlMeasurement& measurement : measurements) {
    if (!known.contains(measurement.keyframe_id)) {
      throw InputError(
          fmt::format("a control point is seen by keyframe {}, which the map does not have",
                      measurement.keyframe_id));
    }
    if (!(measurement.sigma_m > 0) || !measurement.p_base.allFinite() ||
        !measurement.p_site.allFinite()) {
      throw InputError("a control point must have finite coordinates and sigma_m > 0");
    }
  }
}

/// The map's graph and, as further nodes, the building and each control point. The points are
/// rigidly connected with the building; what a keyframe measures of a point is its position, and
/// next to nothing of its direction.
class ControlledGraph {
 public:
  ControlledGraph(const MapGraph& graph,
                  std::span<const ControlMeasurement> measurements,
                  const Similarity2& S_site_map);

  /// Moves the poses to the optimum. @param edge_factor  of the covariances of the map's edges.
  void Solve(double edge_factor, const PoseGraphParams& params);
  /// The median of the points' squared residuals in units of their variance.
  [[nodiscard]] double MedianChi2() const;
  [[nodiscard]] std::vector<Eigen::Matrix3d> Covariances(const PoseGraphParams& params) const {
    return MarginalCovariances(edges_, fixed_, poses_, params);
  }
  [[nodiscard]] const std::vector<Pose2>& Poses() const { return poses_; }

 private:
  std::vector<Edge> edges_;  // of the map, then two of each point: from the site, from a keyframe
  std::vector<Eigen::Matrix3d> informations_;  // of the map's edges
  std::vector<std::int64_t> fixed_;
  std::vector<Pose2> poses_;
};

Eigen::Matrix3d PositionInformation(double sigma, double yaw_information) {
  const double information = 1 / (sigma * sigma);
  return Eigen::Vector3d(information, information, yaw_information).asDiagonal();
}

ControlledGraph::ControlledGraph(const MapGraph& graph,
                                 std::span<const ControlMeasurement> measurements,
                                 const Similarity2& S_site_map)
    : edges_(graph.edges), fixed_({graph.keyframes.front().id}), poses_(PosesById(graph)) {
  // Standard deviations of the direction of a point: of one radian a keyframe notices nothing.
  constexpr double kUnknownYaw = 1;
  constexpr double kRigidYaw = 1e8;
  constexpr double kRigid = 0.1;  // of a point's standard deviation
  for (const Edge& edge : edges_) informations_.push_back(edge.information);
  // In map units, and relative to the first point: coordinates of a country are large.
  const Eigen::Vector2d origin = measurements.front().p_site;
  const auto site = static_cast<std::int64_t>(poses_.size());
  const Similarity2 S_map_site = S_site_map.Inverse();
  const Eigen::Vector2d p = S_map_site * origin;
  const Pose2 T_map_site{p.x(), p.y(), S_map_site.motion.yaw};
  poses_.push_back(T_map_site);
  for (const ControlMeasurement& measurement : measurements) {
    const Eigen::Vector2d p_site = S_map_site.scale * (measurement.p_site - origin);
    const Pose2 T_site_point{p_site.x(), p_site.y(), 0};
    const double sigma = S_map_site.scale * measurement.sigma_m;
    const auto point = static_cast<std::int64_t>(poses_.size());
    poses_.push_back(T_map_site * T_site_point);
    edges_.push_back({site,
                      point,
                      Edge::Kind::kOdometry,
                      T_site_point,
                      PositionInformation(kRigid * sigma, kRigidYaw)});
    const auto keyframe = static_cast<std::size_t>(measurement.keyframe_id);
    const double yaw = WrapAngle(T_map_site.yaw - poses_[keyframe].yaw);
    edges_.push_back({measurement.keyframe_id,
                      point,
                      Edge::Kind::kLoopClosure,
                      {measurement.p_base.x(), measurement.p_base.y(), yaw},
                      PositionInformation(sigma, kUnknownYaw)});
  }
}

void ControlledGraph::Solve(double edge_factor, const PoseGraphParams& params) {
  for (std::size_t i = 0; i < informations_.size(); ++i) {
    edges_[i].information = informations_[i] / edge_factor;
  }
  OptimizePoses(edges_, fixed_, poses_, params);
}

double ControlledGraph::MedianChi2() const {
  std::vector<double> all;
  for (std::size_t i = informations_.size() + 1; i < edges_.size(); i += 2) {
    const Edge& edge = edges_[i];
    all.push_back(EdgeChi2(edge,
                           poses_[static_cast<std::size_t>(edge.from)],
                           poses_[static_cast<std::size_t>(edge.to)]));
  }
  return Median(std::move(all));
}

}  // namespace

void Straighten(MapGraph& graph,
                std::span<const ControlMeasurement> measurements,
                const Similarity2& S_site_map,
                const PoseGraphParams& params) {
  if (graph.keyframes.empty() || measurements.empty()) return;
  CheckMeasurements(graph, measurements);
  const std::vector<Tie> ties = Ties(graph);
  const Legs legs = LegsOf(graph);
  ControlledGraph controlled(graph, measurements, S_site_map);
  // A bend has causes that all edges have in common (lens, mounting), which their covariances do
  // not contain. They are enlarged until the points fit as well as their standard deviations say.
  constexpr double kMedianOfChi2With2 = 1.386;
  constexpr double kMaxFactor = 1e5;
  PoseGraphParams plain = params;
  plain.loop_loss_scale = 0;
  double factor = std::max(1.0, graph.quality.chi2_per_dof);
  for (controlled.Solve(factor, plain);
       controlled.MedianChi2() > kMedianOfChi2With2 && factor < kMaxFactor;
       controlled.Solve(factor, plain)) {
    factor *= 2;
  }
  controlled.Solve(factor, params);  // without the influence of wrong points
  const auto covariances = controlled.Covariances(params);
  PlaceKeyframes(graph, controlled.Poses(), covariances, 1);
  MeasureQuality(graph, controlled.Poses(), graph.quality);
  PlaceFrames(graph, ties, legs, factor);
}

}  // namespace ceilmap::graph
