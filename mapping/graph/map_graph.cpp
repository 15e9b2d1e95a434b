#include "mapping/graph/map_graph.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include "calib/base/pose_with_covariance.hpp"
#include "mapping/graph/frame_ties.hpp"
#include "mapping/graph/optimized_graph.hpp"

namespace ceilmap::graph {
namespace {

double Chi2(const Edge& edge, const std::vector<Pose2>& poses) {
  return EdgeChi2(
      edge, poses[static_cast<std::size_t>(edge.from)], poses[static_cast<std::size_t>(edge.to)]);
}

/// Typical ratio of the squared residuals to the edges' covariances, at least 1. The median is
/// used, so that false closures have no influence.
double ClaimFactor(const MapGraph& graph, const std::vector<Pose2>& poses) {
  std::vector<double> all;
  for (const Edge& edge : graph.edges) all.push_back(Chi2(edge, poses));
  const double n = static_cast<double>(graph.edges.size());
  const double dof = n - static_cast<double>(graph.keyframes.size()) + 1;
  if (dof <= 0) return 1;  // no redundant edge: the errors cannot be estimated
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  constexpr double kMedianOfChi2With3 = 2.366;
  return std::max(1.0, *middle / kMedianOfChi2With3 * n / dof);
}

/// Removes the loop closures that contradict the optimum; returns their number.
std::int64_t RemoveOutliers(std::vector<Edge>& edges,
                            const std::vector<Pose2>& poses,
                            double max_chi2) {
  return static_cast<std::int64_t>(std::erase_if(edges, [&](const Edge& edge) {
    return edge.kind == Edge::Kind::kLoopClosure && Chi2(edge, poses) > max_chi2;
  }));
}

}  // namespace

void MeasureQuality(const MapGraph& graph, const std::vector<Pose2>& poses, MapQuality& quality) {
  double sum = 0;
  double largest = 0;
  std::array<double, 2> squares{};
  std::array<std::int64_t, 2> counts{};
  for (const Edge& edge : graph.edges) {
    const double chi2 = Chi2(edge, poses);
    sum += chi2;
    largest = std::max(largest, chi2);
    if (edge.kind == Edge::Kind::kWheels) continue;
    const Eigen::Vector3d residual = EdgeResidual(
        edge, poses[static_cast<std::size_t>(edge.from)], poses[static_cast<std::size_t>(edge.to)]);
    const std::size_t kind = edge.kind == Edge::Kind::kLoopClosure ? 1 : 0;
    squares[kind] += residual.head<2>().squaredNorm() / 2;
    ++counts[kind];
  }
  const double unknowns = 3.0 * (static_cast<double>(graph.keyframes.size()) - 1);
  const double dof = 3.0 * static_cast<double>(graph.edges.size()) - unknowns;
  quality.chi2_per_dof = dof > 0 ? sum / dof : 0;
  quality.max_edge_sigmas = std::sqrt(largest);
  const auto rms = [&](std::size_t kind) {
    return counts[kind] > 0 ? std::sqrt(squares[kind] / static_cast<double>(counts[kind])) : 0.0;
  };
  quality.odometry_rms = rms(0);
  quality.loop_rms = rms(1);
}

LoopCounts& LoopCounts::operator+=(const LoopCounts& other) {
  compared += other.compared;
  accepted += other.accepted;
  no_match += other.no_match;
  ambiguous += other.ambiguous;
  off_prediction += other.off_prediction;
  unconfirmed += other.unconfirmed;
  outliers += other.outliers;
  return *this;
}

const char* ToString(WeakSpot::Kind kind) {
  switch (kind) {
    case WeakSpot::Kind::kAmbiguous:
      return "ambiguous";
    case WeakSpot::Kind::kLost:
      return "lost";
    case WeakSpot::Kind::kUnclosed:
      return "unclosed";
  }
  return "?";
}

std::vector<Pose2> PosesById(const MapGraph& graph) {
  std::vector<Pose2> poses;
  if (graph.keyframes.empty()) return poses;
  poses.resize(static_cast<std::size_t>(graph.keyframes.back().id) + 1);
  for (const Keyframe& keyframe : graph.keyframes) {
    poses[static_cast<std::size_t>(keyframe.id)] = keyframe.pose.T_map_base;
  }
  return poses;
}

void MoveKeyframes(MapGraph& graph, const std::vector<Pose2>& poses) {
  const KeyframesById keyframes = ById(graph.keyframes);
  const auto move = [&](FramePose& pose, std::int64_t keyframe_id, const Pose2& keyframe_before) {
    const Pose2 T_new_old =
        poses[static_cast<std::size_t>(keyframe_id)] * keyframe_before.Inverse();
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = T_new_old.Rotation();
    pose.T_map_base = T_new_old * pose.T_map_base;
    pose.covariance = turn * pose.covariance * turn.transpose();
  };
  const Legs legs = LegsOf(graph);
  for (FramePose& frame : graph.trajectory) {
    const Pose2& before = keyframes.at(frame.keyframe_id)->pose.T_map_base;
    if (const Leg* const leg = LegOf(legs, frame)) {
      const Pose2& after = poses[static_cast<std::size_t>(frame.keyframe_id)];
      const Pose2& next = poses[static_cast<std::size_t>(leg->next_id)];
      frame.T_map_base = before * Stretched(before.Inverse() * frame.T_map_base,
                                            frame.frame_index,
                                            *leg,
                                            after.Inverse() * next);
    }
    move(frame, frame.keyframe_id, before);
  }
  for (Keyframe& keyframe : graph.keyframes) {
    move(keyframe.pose, keyframe.id, keyframe.pose.T_map_base);
  }
}

double PathLength(const std::vector<FramePose>& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    length += (trajectory[i].T_map_base.Translation() - trajectory[i - 1].T_map_base.Translation())
                  .norm();
  }
  return length;
}

std::vector<std::vector<std::int64_t>> Components(const MapGraph& graph) {
  std::unordered_map<std::int64_t, std::vector<std::int64_t>> neighbours;
  for (const Edge& edge : graph.edges) {
    neighbours[edge.from].push_back(edge.to);
    neighbours[edge.to].push_back(edge.from);
  }
  std::unordered_set<std::int64_t> seen;
  std::vector<std::vector<std::int64_t>> components;
  for (const Keyframe& start : graph.keyframes) {
    if (!seen.insert(start.id).second) continue;
    std::vector<std::int64_t> component = {start.id};
    for (std::size_t i = 0; i < component.size(); ++i) {
      for (const std::int64_t next : neighbours[component[i]]) {
        if (seen.insert(next).second) component.push_back(next);
      }
    }
    std::sort(component.begin(), component.end());
    components.push_back(std::move(component));
  }
  std::stable_sort(components.begin(), components.end(), [](const auto& a, const auto& b) {
    return a.size() > b.size();
  });
  return components;
}

void KeepOnly(MapGraph& graph, const std::unordered_set<std::int64_t>& keyframe_ids) {
  const auto gone = [&](std::int64_t id) { return !keyframe_ids.contains(id); };
  std::erase_if(graph.keyframes, [&](const Keyframe& k) { return gone(k.id); });
  std::erase_if(graph.edges, [&](const Edge& e) { return gone(e.from) || gone(e.to); });
  std::erase_if(graph.trajectory, [&](const FramePose& f) { return gone(f.keyframe_id); });
  std::erase_if(graph.weak_spots, [&](const WeakSpot& s) { return gone(s.keyframe_id); });
}

namespace {

/// A motion of base of which the camera measured the distance with an error of scale: rotations
/// about base move the camera by distances that are known.
Pose2 Scaled(const Pose2& T, double factor, const Pose2& T_base_view) {
  Pose2 view = T_base_view.Inverse() * T * T_base_view;
  view.x *= factor;
  view.y *= factor;
  return T_base_view * view * T_base_view.Inverse();
}

void ScaleEdge(Edge& edge, double factor, const Pose2& T_base_view) {
  edge.T_from_to = Scaled(edge.T_from_to, factor, T_base_view);
  edge.information.topLeftCorner<2, 2>() /= factor * factor;
  edge.information.topRightCorner<2, 1>() /= factor;
  edge.information.bottomLeftCorner<1, 2>() /= factor;
}

void ScaleHeights(Keyframe& keyframe, double factor) {
  if (!keyframe.heights) return;
  auto heights = std::make_shared<heights::HeightField>(*keyframe.heights);
  heights->Scale(1 / factor);
  keyframe.heights = std::move(heights);
}

}  // namespace

void Scale(MapGraph& graph, double factor, const Pose2& T_base_view) {
  // Poses are relative to the first one, whose own pose is not measured.
  const Pose2 T_map_first = graph.keyframes.front().pose.T_map_base;
  const auto scale = [&](FramePose& pose) {
    pose.T_map_base =
        T_map_first * Scaled(T_map_first.Inverse() * pose.T_map_base, factor, T_base_view);
    pose.covariance.topLeftCorner<2, 2>() *= factor * factor;
    pose.covariance.topRightCorner<2, 1>() *= factor;
    pose.covariance.bottomLeftCorner<1, 2>() *= factor;
  };
  for (Keyframe& keyframe : graph.keyframes) {
    scale(keyframe.pose);
    ScaleHeights(keyframe, factor);
  }
  for (FramePose& frame : graph.trajectory) scale(frame);
  for (Edge& edge : graph.edges) ScaleEdge(edge, factor, T_base_view);
}

namespace {

/// Moves each keyframe with the one before it, whose way to it grows by a factor where the camera
/// measured it. @return the poses before, by id.
template <typename FactorOf>
std::unordered_map<std::int64_t, Pose2> ScaleWays(MapGraph& graph,
                                                  const FactorOf& factor_of,
                                                  const Pose2& T_base_view) {
  const Legs legs = LegsOf(graph);
  std::unordered_map<std::int64_t, Pose2> before;
  const Keyframe* last = nullptr;
  for (Keyframe& keyframe : graph.keyframes) {
    Pose2& T_map_keyframe = keyframe.pose.T_map_base;
    before[keyframe.id] = T_map_keyframe;
    if (last != nullptr) {
      const auto leg = legs.find(last->id);
      const bool measured = leg != legs.end() && !leg->second.by_wheels;
      const Pose2 T_last_keyframe = before.at(last->id).Inverse() * T_map_keyframe;
      T_map_keyframe = last->pose.T_map_base *
                       Scaled(T_last_keyframe, measured ? factor_of(last->id) : 1, T_base_view);
    }
    last = &keyframe;
  }
  return before;
}

}  // namespace

void ScaleMotions(MapGraph& graph,
                  const std::unordered_map<std::int64_t, double>& factors,
                  const Pose2& T_base_view) {
  const auto factor_of = [&factors](std::int64_t id) {
    const auto found = factors.find(id);
    return found == factors.end() ? 1.0 : found->second;
  };
  const auto before = ScaleWays(graph, factor_of, T_base_view);
  for (Keyframe& keyframe : graph.keyframes) ScaleHeights(keyframe, factor_of(keyframe.id));
  const KeyframesById keyframes = ById(graph.keyframes);
  for (FramePose& frame : graph.trajectory) {
    const auto keyframe = keyframes.find(frame.keyframe_id);
    if (keyframe == keyframes.end()) continue;
    const bool by_wheels = frame.status == TrackingStatus::kPredicted;
    const Pose2 T_keyframe_frame = before.at(frame.keyframe_id).Inverse() * frame.T_map_base;
    frame.T_map_base =
        keyframe->second->pose.T_map_base *
        Scaled(T_keyframe_frame, by_wheels ? 1 : factor_of(frame.keyframe_id), T_base_view);
  }
  for (Edge& edge : graph.edges) {
    if (edge.kind != Edge::Kind::kWheels) ScaleEdge(edge, factor_of(edge.from), T_base_view);
  }
}

void MoveAll(MapGraph& graph, const Pose2& T_new_old) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = T_new_old.Rotation();
  const auto move = [&](FramePose& pose) {
    pose.T_map_base = T_new_old * pose.T_map_base;
    pose.covariance = turn * pose.covariance * turn.transpose();
  };
  for (Keyframe& keyframe : graph.keyframes) move(keyframe.pose);
  for (FramePose& frame : graph.trajectory) move(frame);
  for (WeakSpot& spot : graph.weak_spots) {
    const Eigen::Vector2d p = T_new_old * Eigen::Vector2d(spot.x, spot.y);
    spot.x = p.x();
    spot.y = p.y();
  }
}

void PlaceKeyframes(MapGraph& graph,
                    const std::vector<Pose2>& poses,
                    const std::vector<Eigen::Matrix3d>& covariances,
                    double variance_factor) {
  for (Keyframe& keyframe : graph.keyframes) {
    const auto index = static_cast<std::size_t>(keyframe.id);
    keyframe.pose.T_map_base = poses[index];
    keyframe.pose.covariance = variance_factor * covariances[index];
  }
  for (WeakSpot& spot : graph.weak_spots) {
    spot.x = poses[static_cast<std::size_t>(spot.keyframe_id)].x;
    spot.y = poses[static_cast<std::size_t>(spot.keyframe_id)].y;
  }
}

void Optimize(MapGraph& graph,
              const PoseGraphParams& params,
              const std::vector<std::int64_t>& held) {
  // A loop closure with a larger residual, in sigmas, is removed when the rest of the graph agrees
  // without it.
  constexpr double kMaxSigmas = 6;
  if (graph.keyframes.empty()) return;
  const std::vector<Tie> ties = Ties(graph);
  const Legs legs = LegsOf(graph);
  const std::vector<std::int64_t> fixed =
      held.empty() ? std::vector<std::int64_t>{graph.keyframes.front().id} : held;
  std::vector<Pose2> poses = PosesById(graph);
  // Where all residuals are larger than the edges' covariances predict, the covariances are wrong
  // and not the edges. Outliers are therefore judged relative to the typical residual on this
  // ceiling, which a first plain least-squares solution gives.
  PoseGraphParams plain = params;
  plain.loop_loss_scale = 0;
  OptimizePoses(graph.edges, fixed, poses, plain);
  double factor = ClaimFactor(graph, poses);
  PoseGraphParams robust = params;
  constexpr int kMaxRounds = 6;
  for (int round = 0; round < kMaxRounds; ++round) {
    robust.loop_loss_scale = params.loop_loss_scale * std::sqrt(factor);
    OptimizePoses(graph.edges, fixed, poses, robust);
    const double before = factor;
    factor = std::min(factor, ClaimFactor(graph, poses));
    const std::int64_t removed =
        RemoveOutliers(graph.edges, poses, factor * kMaxSigmas * kMaxSigmas);
    graph.quality.loops.outliers += removed;
    if (removed == 0 && factor > 0.8 * before) break;
  }
  MeasureQuality(graph, poses, graph.quality);
  const double variance_factor = std::max(1.0, graph.quality.chi2_per_dof);
  const auto covariances = MarginalCovariances(graph.edges, fixed, poses, robust);
  PlaceKeyframes(graph, poses, covariances, variance_factor);
  PlaceFrames(graph, ties, legs, variance_factor);
}

namespace {

/// Adds a spot for each run of consecutive keyframes for which `weak` holds and whose length is at
/// least `min_length`.
template <typename Predicate>
void AddRuns(WeakSpot::Kind kind, double min_length, const Predicate& weak, MapGraph& graph) {
  const std::vector<Keyframe>& keyframes = graph.keyframes;
  for (std::size_t first = 0; first < keyframes.size(); ++first) {
    if (!weak(keyframes[first])) continue;
    double length = 0;
    std::size_t last = first;
    for (; last + 1 < keyframes.size() && weak(keyframes[last + 1]); ++last) {
      length += (keyframes[last + 1].pose.T_map_base.Translation() -
                 keyframes[last].pose.T_map_base.Translation())
                    .norm();
    }
    const Keyframe& middle = keyframes[(first + last) / 2];
    const Pose2& T = middle.pose.T_map_base;
    if (length >= min_length) graph.weak_spots.push_back({kind, middle.id, T.x, T.y, length});
    first = last;
  }
}

}  // namespace

void FindWeakSpots(MapGraph& graph, double view_span) {
  std::erase_if(graph.weak_spots,
                [](const WeakSpot& spot) { return spot.kind != WeakSpot::Kind::kLost; });
  std::unordered_set<std::int64_t> closed;
  for (const Edge& edge : graph.edges) {
    // An overlap with the last few keyframes is no loop closure.
    constexpr std::int64_t kAlongTheWay = 10;
    if (edge.kind != Edge::Kind::kLoopClosure) continue;
    if (std::abs(edge.to - edge.from) <= kAlongTheWay) continue;
    closed.insert(edge.from);
    closed.insert(edge.to);
  }
  AddRuns(
      WeakSpot::Kind::kAmbiguous, 0, [](const Keyframe& k) { return k.ambiguous; }, graph);
  AddRuns(
      WeakSpot::Kind::kUnclosed,
      view_span,
      [&closed](const Keyframe& k) { return !closed.contains(k.id); },
      graph);
}

}  // namespace ceilmap::graph
