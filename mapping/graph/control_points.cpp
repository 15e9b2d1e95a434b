#include "mapping/graph/control_points.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
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

  /// Moves the poses to the optimum, with the smallest factor of the covariances of the map's edges
  /// with which the points fit as well as `measure` of their squared residuals asks.
  /// @param least  factor to begin with.
  struct Fit {
    double (*measure)(const std::vector<double>& chi2);
    double most = 0;
  };
  double Solve(double least, const Fit& fit, const PoseGraphParams& params);
  /// Squared residuals of the points in units of their variance.
  [[nodiscard]] std::vector<double> Chi2() const;
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

double ControlledGraph::Solve(double least, const Fit& fit, const PoseGraphParams& params) {
  constexpr double kStep = 4;
  constexpr double kMaxFactor = 1e6;
  for (double factor = least;; factor *= kStep) {
    for (std::size_t i = 0; i < informations_.size(); ++i) {
      edges_[i].information = informations_[i] / factor;
    }
    OptimizePoses(edges_, fixed_, poses_, params);
    if (fit.measure(Chi2()) <= fit.most || factor > kMaxFactor) return factor;
  }
}

std::vector<double> ControlledGraph::Chi2() const {
  std::vector<double> all;
  for (std::size_t i = informations_.size() + 1; i < edges_.size(); i += 2) {
    const Edge& edge = edges_[i];
    all.push_back(EdgeChi2(edge,
                           poses_[static_cast<std::size_t>(edge.from)],
                           poses_[static_cast<std::size_t>(edge.to)]));
  }
  return all;
}

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}
double MedianOf(const std::vector<double>& values) {
  return Median(values);
}
// Of squared residuals with two degrees of freedom; a wrong point has no influence on the median.
const ControlledGraph::Fit kMeanFit{&Mean, 2};
const ControlledGraph::Fit kMedianFit{&MedianOf, 1.386};

/// A choice of the measurements, and the graph with them.
struct Agreement {
  std::vector<std::size_t> used;
  std::optional<ControlledGraph> controlled;
  double factor = 1;
};

class Chooser {
 public:
  Chooser(const MapGraph& graph,
          std::span<const ControlMeasurement> measurements,
          const Similarity2& S_site_map,
          const PoseGraphParams& params)
      : graph_(graph),
        measurements_(measurements),
        S_site_map_(S_site_map),
        params_(params),
        least_(std::max(1.0, graph.quality.chi2_per_dof)) {}

  /// All measurements except those that contradict the others.
  [[nodiscard]] Agreement Choose() const;

 private:
  [[nodiscard]] Agreement With(std::vector<std::size_t> used,
                               const ControlledGraph::Fit& fit) const;

  const MapGraph& graph_;
  std::span<const ControlMeasurement> measurements_;
  const Similarity2& S_site_map_;
  const PoseGraphParams& params_;
  double least_;
};

Agreement Chooser::With(std::vector<std::size_t> used, const ControlledGraph::Fit& fit) const {
  Agreement agreement;
  std::vector<ControlMeasurement> chosen;
  chosen.reserve(used.size());
  for (const std::size_t i : used) chosen.push_back(measurements_[i]);
  agreement.used = std::move(used);
  agreement.controlled.emplace(graph_, chosen, S_site_map_);
  agreement.factor = agreement.controlled->Solve(least_, fit, params_);
  return agreement;
}

Agreement Chooser::Choose() const {
  constexpr double kContradicts = 30;  // times the factor without the point
  constexpr std::size_t kMinPoints = 5;
  std::vector<std::size_t> all(measurements_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  Agreement best = With(std::move(all), kMeanFit);
  while (best.factor >= kContradicts * least_ && best.used.size() > kMinPoints) {
    const std::vector<double> chi2 = With(best.used, kMedianFit).controlled->Chi2();
    std::vector<std::size_t> others = best.used;
    others.erase(others.begin() + (std::max_element(chi2.begin(), chi2.end()) - chi2.begin()));
    Agreement without = With(std::move(others), kMeanFit);
    if (without.factor * kContradicts > best.factor) break;
    best = std::move(without);
  }
  return best;
}

}  // namespace

std::vector<bool> Straighten(MapGraph& graph,
                             std::span<const ControlMeasurement> measurements,
                             const Similarity2& S_site_map,
                             const PoseGraphParams& params) {
  std::vector<bool> used(measurements.size(), false);
  if (graph.keyframes.empty() || measurements.empty()) return used;
  CheckMeasurements(graph, measurements);
  const std::vector<Tie> ties = Ties(graph);
  const Legs legs = LegsOf(graph);
  PoseGraphParams plain = params;  // false closures were removed by Optimize
  plain.loop_loss_scale = 0;
  const Agreement agreement = Chooser(graph, measurements, S_site_map, plain).Choose();
  for (const std::size_t i : agreement.used) used[i] = true;
  const ControlledGraph& controlled = *agreement.controlled;
  PlaceKeyframes(graph, controlled.Poses(), controlled.Covariances(plain), 1);
  MeasureQuality(graph, controlled.Poses(), graph.quality);
  PlaceFrames(graph, ties, legs, agreement.factor);
  return used;
}

}  // namespace ceilmap::graph
