#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <random>

#include "calib/base/pose_with_covariance.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/map_merge.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::graph {
namespace {

constexpr double kSigma = 0.002;      // of an edge, metres
constexpr double kSigmaRad = 0.0005;  // of an edge

/// A robot that drives `laps` times round a circle, with noisy odometry and one closure per lap and
/// keyframe; three frames at each keyframe.
class Circle {
 public:
  explicit Circle(int laps, unsigned seed = 1) : random_(seed) {
    for (int i = 0; i < laps * kPerLap; ++i) {
      const double angle = 2 * std::numbers::pi * i / kPerLap;
      truth.push_back({3 * std::cos(angle), 3 * std::sin(angle), WrapAngle(angle + 1.57)});
      AddKeyframe(i);
      if (i > 0) graph.edges.push_back(Measure(i - 1, i, Edge::Kind::kOdometry));
      if (i >= kPerLap) graph.edges.push_back(Measure(i - kPerLap, i, Edge::Kind::kLoopClosure));
    }
    DeadReckon();
    AddFrames();
  }

  Edge Measure(std::int64_t from, std::int64_t to, Edge::Kind kind) {
    Edge edge{from, to, kind, truth[Index(from)].Inverse() * truth[Index(to)], {}};
    edge.T_from_to.x += kSigma * normal_(random_);
    edge.T_from_to.y += kSigma * normal_(random_);
    edge.T_from_to.yaw += kSigmaRad * normal_(random_);
    edge.information =
        Eigen::Vector3d(1 / (kSigma * kSigma), 1 / (kSigma * kSigma), 1 / (kSigmaRad * kSigmaRad))
            .asDiagonal();
    return edge;
  }

  /// Worst error of a keyframe's place, aligned at the first one.
  [[nodiscard]] double WorstError() const {
    double worst = 0;
    for (const Keyframe& keyframe : graph.keyframes) {
      const Pose2 off = keyframe.pose.T_map_base.Inverse() * truth[Index(keyframe.id)];
      worst = std::max(worst, off.Translation().norm());
    }
    return worst;
  }

  static constexpr int kPerLap = 20;
  MapGraph graph;
  std::vector<Pose2> truth;

 private:
  static std::size_t Index(std::int64_t id) { return static_cast<std::size_t>(id); }

  void AddKeyframe(std::int64_t id) {
    Keyframe keyframe;
    keyframe.id = id;
    keyframe.pose.keyframe_id = id;
    graph.keyframes.push_back(keyframe);
  }
  /// Poses and covariances as an odometry has them.
  void DeadReckon() {
    graph.keyframes.front().pose.T_map_base = truth.front();
    for (const Edge& edge : graph.edges) {
      if (edge.kind != Edge::Kind::kOdometry) continue;
      const FramePose& from = graph.keyframes[Index(edge.from)].pose;
      FramePose& to = graph.keyframes[Index(edge.to)].pose;
      to.T_map_base = from.T_map_base * edge.T_from_to;
      to.covariance = ComposeCovariance(
          from.T_map_base, from.covariance, edge.T_from_to, edge.information.inverse());
    }
  }
  void AddFrames() {
    for (const Keyframe& keyframe : graph.keyframes) {
      for (int i = 0; i < 3; ++i) {
        FramePose frame;
        frame.keyframe_id = keyframe.id;
        frame.T_map_base = keyframe.pose.T_map_base * Tie(i);
        frame.covariance = ComposeCovariance(
            keyframe.pose.T_map_base, keyframe.pose.covariance, Tie(i), TieCovariance());
        graph.trajectory.push_back(frame);
      }
    }
  }

 public:
  static Pose2 Tie(int i) { return {0.1 * i, 0.02, 0.05 * i}; }
  static Eigen::Matrix3d TieCovariance() { return Eigen::Vector3d(1e-6, 2e-6, 3e-8).asDiagonal(); }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

TEST(MapGraph, OptimizeTakesTheDriftOut) {
  Circle circle(3);
  const double before = circle.WorstError();
  Optimize(circle.graph);
  EXPECT_LT(circle.WorstError(), 0.5 * before);
  EXPECT_NEAR(circle.graph.quality.chi2_per_dof, 1, 0.35);
  EXPECT_NEAR(circle.graph.quality.odometry_rms, kSigma, 0.5 * kSigma);
  EXPECT_EQ(circle.graph.quality.loops.outliers, 0);
}

TEST(MapGraph, ErrorsAreWhatTheCovariancesSay) {
  // Normalised squared error of position and heading: 3 on average.
  double sum = 0;
  int count = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Circle circle(3, seed);
    Optimize(circle.graph);
    for (const Keyframe& keyframe : circle.graph.keyframes) {
      if (keyframe.id == 0) continue;
      const Pose2& T = keyframe.pose.T_map_base;
      const Pose2& truth = circle.truth[static_cast<std::size_t>(keyframe.id)];
      const Eigen::Vector3d error(T.x - truth.x, T.y - truth.y, WrapAngle(T.yaw - truth.yaw));
      sum += error.dot(keyframe.pose.covariance.inverse() * error);
      ++count;
    }
  }
  EXPECT_GT(sum / count, 1.5);
  EXPECT_LT(sum / count, 4);
}

TEST(MapGraph, FramesGoWithTheirKeyframesAndKeepTheirOwnSpread) {
  Circle circle(2);
  Optimize(circle.graph);
  const double factor = std::max(1.0, circle.graph.quality.chi2_per_dof);
  for (std::size_t i = 0; i < circle.graph.trajectory.size(); ++i) {
    const FramePose& frame = circle.graph.trajectory[i];
    const FramePose& keyframe =
        circle.graph.keyframes[static_cast<std::size_t>(frame.keyframe_id)].pose;
    const Pose2 tie = keyframe.T_map_base.Inverse() * frame.T_map_base;
    const Pose2 expected = Circle::Tie(static_cast<int>(i % 3));
    EXPECT_NEAR(tie.x, expected.x, 1e-9);
    EXPECT_NEAR(tie.y, expected.y, 1e-9);
    EXPECT_NEAR(tie.yaw, expected.yaw, 1e-9);
    const Eigen::Matrix3d covariance = ComposeCovariance(
        keyframe.T_map_base, keyframe.covariance, expected, factor * Circle::TieCovariance());
    EXPECT_TRUE(frame.covariance.isApprox(covariance, 1e-6));
  }
}

TEST(MapGraph, FalseClosuresAreTakenOut) {
  Circle circle(3);
  Circle clean = circle;
  for (const std::int64_t id : {25, 33, 47}) {
    Edge wrong = circle.Measure(id - 21, id, Edge::Kind::kLoopClosure);
    wrong.T_from_to.x += 0.6;  // a tile too far
    circle.graph.edges.push_back(wrong);
  }
  Optimize(circle.graph);
  Optimize(clean.graph);
  EXPECT_EQ(circle.graph.quality.loops.outliers, 3);
  EXPECT_EQ(circle.graph.edges.size(), clean.graph.edges.size());
  EXPECT_NEAR(circle.WorstError(), clean.WorstError(), 1e-4);
}

TEST(MapGraph, ResidualsLargerThanClaimedWidenTheCovariances) {
  Circle honest(3);
  Circle boastful(3);
  for (Edge& edge : boastful.graph.edges) edge.information *= 100;
  Optimize(honest.graph);
  Optimize(boastful.graph);
  EXPECT_GT(boastful.graph.quality.chi2_per_dof, 50);
  const Eigen::Matrix3d& a = honest.graph.keyframes[30].pose.covariance;
  const Eigen::Matrix3d& b = boastful.graph.keyframes[30].pose.covariance;
  EXPECT_NEAR(b.trace() / a.trace(), 1, 0.4);
}

TEST(MapGraph, ComponentsAreFoundAndUnconnectedOnesLeave) {
  Circle circle(2);
  std::erase_if(circle.graph.edges, [](const Edge& e) {
    return (e.from < 25) != (e.to < 25) || e.kind == Edge::Kind::kLoopClosure;
  });
  const auto components = Components(circle.graph);
  ASSERT_EQ(components.size(), 2U);
  EXPECT_EQ(components[0].size(), 25U);
  EXPECT_EQ(components[1].front(), 25);
  KeepOnly(circle.graph, {components[1].begin(), components[1].end()});
  EXPECT_EQ(circle.graph.keyframes.size(), 15U);
  EXPECT_EQ(circle.graph.trajectory.size(), 45U);
  EXPECT_EQ(circle.graph.edges.size(), 14U);
}

TEST(MapGraph, WeakSpotsAreNamed) {
  Circle circle(1);  // nothing closes
  for (const int id : {6, 7, 8, 12}) circle.graph.keyframes[id].ambiguous = true;
  circle.graph.weak_spots.push_back({WeakSpot::Kind::kLost, 3, 0, 0, 12});
  Optimize(circle.graph);
  FindWeakSpots(circle.graph, 2);
  FindWeakSpots(circle.graph, 2);  // finds them anew, not once more
  ASSERT_EQ(circle.graph.weak_spots.size(), 4U);
  EXPECT_EQ(circle.graph.weak_spots[0].kind, WeakSpot::Kind::kLost);
  EXPECT_NEAR(circle.graph.weak_spots[0].x, circle.graph.keyframes[3].pose.T_map_base.x, 1e-12);
  EXPECT_EQ(circle.graph.weak_spots[1].kind, WeakSpot::Kind::kAmbiguous);
  EXPECT_EQ(circle.graph.weak_spots[1].keyframe_id, 7);
  EXPECT_NEAR(circle.graph.weak_spots[1].extent, 2 * 6 * std::sin(std::numbers::pi / 20), 0.01);
  EXPECT_EQ(circle.graph.weak_spots[2].keyframe_id, 12);
  EXPECT_EQ(circle.graph.weak_spots[2].extent, 0);
  EXPECT_EQ(circle.graph.weak_spots[3].kind, WeakSpot::Kind::kUnclosed);
  EXPECT_NEAR(circle.graph.weak_spots[3].extent, 19 * 6 * std::sin(std::numbers::pi / 20), 0.05);
  Circle closed(3);
  FindWeakSpots(closed.graph, 2);
  EXPECT_TRUE(closed.graph.weak_spots.empty());
}

TEST(MapGraph, MovingAllKeepsEverythingInPlaceToEachOther) {
  Circle circle(2);
  MapGraph moved = circle.graph;
  const Pose2 T{4, -3, 2};
  MoveAll(moved, T);
  std::vector<Pose2> poses = PosesById(circle.graph);
  for (Pose2& pose : poses) pose = T * pose;
  MapGraph by_keyframes = circle.graph;
  MoveKeyframes(by_keyframes, poses);
  for (std::size_t i = 0; i < moved.trajectory.size(); ++i) {
    EXPECT_NEAR(moved.trajectory[i].T_map_base.x, by_keyframes.trajectory[i].T_map_base.x, 1e-9);
    EXPECT_NEAR(moved.trajectory[i].T_map_base.y, by_keyframes.trajectory[i].T_map_base.y, 1e-9);
    EXPECT_TRUE(moved.trajectory[i].covariance.isApprox(by_keyframes.trajectory[i].covariance));
  }
}

TEST(MapGraph, MotionsAreScaledByTheirKeyframe) {
  Circle circle(1);
  const Pose2 T_base_view{0.2, 0, 1.57};
  MapGraph scaled = circle.graph;
  heights::HeightField field;
  field.grid = {1, 1};
  field.cells = {{1.2F, 0.01F}};
  scaled.keyframes[2].heights = std::make_shared<const heights::HeightField>(field);
  ScaleMotions(scaled, {{2, 1.25}}, T_base_view);
  EXPECT_FLOAT_EQ(scaled.keyframes[2].heights->cells[0].rho, 1.2F / 1.25F);
  for (std::size_t i = 0; i < scaled.edges.size(); ++i) {
    // The camera's way grows, the turn stays.
    const Pose2 before = T_base_view.Inverse() * circle.graph.edges[i].T_from_to * T_base_view;
    const Pose2 after = T_base_view.Inverse() * scaled.edges[i].T_from_to * T_base_view;
    const double factor = scaled.edges[i].from == 2 ? 1.25 : 1;
    EXPECT_NEAR(after.x, factor * before.x, 1e-12);
    EXPECT_NEAR(after.y, factor * before.y, 1e-12);
    EXPECT_NEAR(after.yaw, before.yaw, 1e-12);
    EXPECT_NEAR(scaled.edges[i].information(0, 0) * factor * factor,
                circle.graph.edges[i].information(0, 0),
                1e-6);
  }
  for (std::size_t i = 0; i < scaled.trajectory.size(); ++i) {
    const auto id = static_cast<std::size_t>(scaled.trajectory[i].keyframe_id);
    const auto of_view = [&](const MapGraph& graph) {
      return T_base_view.Inverse() * graph.keyframes[id].pose.T_map_base.Inverse() *
             graph.trajectory[i].T_map_base * T_base_view;
    };
    const double factor = id == 2 ? 1.25 : 1;
    EXPECT_NEAR(of_view(scaled).x, factor * of_view(circle.graph).x, 1e-9) << i;
    EXPECT_NEAR(of_view(scaled).y, factor * of_view(circle.graph).y, 1e-9) << i;
  }
  const auto to_next = [](const MapGraph& graph) {
    return graph.keyframes[2].pose.T_map_base.Inverse() * graph.keyframes[3].pose.T_map_base;
  };
  const Pose2 way = T_base_view.Inverse() * to_next(circle.graph) * T_base_view;
  const Pose2 longer = T_base_view.Inverse() * to_next(scaled) * T_base_view;
  EXPECT_NEAR(longer.x, 1.25 * way.x, 1e-12);
  EXPECT_NEAR(longer.y, 1.25 * way.y, 1e-12);
}

/// Keyframes in a line, each ten frames and a step, m, from the one before.
MapGraph StraightKeyframes(int count, double step) {
  MapGraph graph;
  for (int i = 0; i < count; ++i) {
    Keyframe keyframe;
    keyframe.id = keyframe.pose.keyframe_id = i;
    keyframe.pose.frame_index = 10 * i;
    keyframe.pose.T_map_base = {step * i, 0, 0};
    graph.keyframes.push_back(keyframe);
  }
  return graph;
}

TEST(MapGraph, ScaledFramesStayBetweenTheirKeyframesWhenTheGraphIsOptimized) {
  // The camera measured 0.8 of all ways.
  MapGraph graph = StraightKeyframes(5, 0.8);
  for (const Keyframe& keyframe : graph.keyframes) {
    if (keyframe.id > 0) {
      graph.edges.push_back({keyframe.id - 1,
                             keyframe.id,
                             Edge::Kind::kOdometry,
                             {0.8, 0, 0},
                             1e4 * Eigen::Matrix3d::Identity()});
    }
    for (int f = 0; f < 10; ++f) {
      FramePose frame = keyframe.pose;
      frame.frame_index += f;
      frame.T_map_base.x += 0.08 * f;
      graph.trajectory.push_back(frame);
    }
  }
  std::unordered_map<std::int64_t, double> factors;
  for (const Keyframe& keyframe : graph.keyframes) factors[keyframe.id] = 1.25;
  ScaleMotions(graph, factors, {});
  Optimize(graph);
  for (const FramePose& frame : graph.trajectory) {
    EXPECT_NEAR(frame.T_map_base.x, 0.1 * static_cast<double>(frame.frame_index), 1e-6);
  }
}

/// Two keyframes that are 2 m apart, and frames of the first one.
MapGraph TwoKeyframes(Edge::Kind kind) {
  MapGraph graph = StraightKeyframes(2, 2);
  graph.edges.push_back({0, 1, kind, {2, 0, 0}, Eigen::Matrix3d::Identity()});
  for (const auto& [index, x] : {std::pair(2, 0.5), std::pair(9, 1.8), std::pair(12, 2.4)}) {
    FramePose frame;
    frame.frame_index = index;
    frame.keyframe_id = 0;
    frame.T_map_base = {x, 0, 0};
    graph.trajectory.push_back(frame);
  }
  return graph;
}

TEST(MapGraph, WhatWheelsMeasuredIsNotScaled) {
  for (const auto kind : {Edge::Kind::kWheels, Edge::Kind::kOdometry}) {
    MapGraph graph = TwoKeyframes(kind);
    graph.trajectory[0].status = TrackingStatus::kTracking;
    graph.trajectory[1].status = TrackingStatus::kPredicted;
    ScaleMotions(graph, {{0, 1.1}}, {});
    const double expected = kind == Edge::Kind::kWheels ? 2 : 2.2;
    EXPECT_NEAR(graph.edges[0].T_from_to.x, expected, 1e-12);
    EXPECT_NEAR(graph.keyframes[1].pose.T_map_base.x, expected, 1e-12);
    EXPECT_NEAR(graph.trajectory[0].T_map_base.x, 0.55, 1e-12) << "seen by the camera";
    EXPECT_NEAR(graph.trajectory[1].T_map_base.x, 1.8, 1e-12) << "by wheels";
  }
}

TEST(MapGraph, FramesBetweenTwoKeyframesShareTheCorrection) {
  MapGraph graph = TwoKeyframes(Edge::Kind::kOdometry);
  MoveKeyframes(graph, {{0, 0, 0}, {2.2, -0.1, 0.02}});
  EXPECT_NEAR(graph.trajectory[0].T_map_base.x, 0.55, 1e-12);
  EXPECT_NEAR(graph.trajectory[0].T_map_base.y, -0.025, 1e-12);
  EXPECT_NEAR(graph.trajectory[0].T_map_base.yaw, 0.005, 1e-12);
  EXPECT_NEAR(graph.trajectory[1].T_map_base.x, 1.98, 1e-12);
  // It was placed by the earlier keyframe alone, after the later one.
  EXPECT_NEAR(graph.trajectory[2].T_map_base.x, 2.4, 1e-12);
}

// The wheels slipped in the dark between the two keyframes: where the ceiling was seen before it,
// nothing changes.
TEST(MapGraph, FramesBeforeADarkWayKeepTheirPlace) {
  MapGraph graph = TwoKeyframes(Edge::Kind::kWheels);
  graph.trajectory[1].status = TrackingStatus::kPredicted;
  MoveKeyframes(graph, {{0, 0, 0}, {2.2, -0.1, 0.02}});
  EXPECT_NEAR(graph.trajectory[0].T_map_base.x, 0.5, 1e-12);
  EXPECT_NEAR(graph.trajectory[0].T_map_base.y, 0, 1e-12);
  EXPECT_NEAR(graph.trajectory[1].T_map_base.x, 1.98, 1e-12) << "by the wheels";
}

TEST(MapGraph, ChangingTheViewChangesNoImagesPlace) {
  Circle circle(2);
  MapGraph changed = circle.graph;
  const Pose2 own{0.2, -0.1, 0.4};
  const Pose2 other{-0.3, 0.5, -1.2};
  mapping::ChangeView(changed, own, other);
  for (std::size_t i = 0; i < changed.keyframes.size(); ++i) {
    const Pose2 off = (circle.graph.keyframes[i].pose.T_map_base * own).Inverse() *
                      (changed.keyframes[i].pose.T_map_base * other);
    EXPECT_NEAR(off.Translation().norm(), 0, 1e-12);
    EXPECT_NEAR(off.yaw, 0, 1e-12);
  }
  // The graph is equivalent: each edge fits as well as before.
  const std::vector<Pose2> before = PosesById(circle.graph);
  const std::vector<Pose2> after = PosesById(changed);
  for (std::size_t i = 0; i < changed.edges.size(); ++i) {
    const Edge& a = circle.graph.edges[i];
    const Edge& b = changed.edges[i];
    const auto from = static_cast<std::size_t>(a.from);
    const auto to = static_cast<std::size_t>(a.to);
    EXPECT_NEAR(EdgeChi2(a, before[from], before[to]),
                EdgeChi2(b, after[from], after[to]),
                1e-2 * EdgeChi2(a, before[from], before[to]) + 1e-6);
  }
  // There and back again.
  mapping::ChangeView(changed, other, own);
  for (std::size_t i = 0; i < changed.edges.size(); ++i) {
    EXPECT_TRUE(changed.edges[i].information.isApprox(circle.graph.edges[i].information, 1e-9));
  }
  for (std::size_t i = 0; i < changed.keyframes.size(); ++i) {
    EXPECT_TRUE(changed.keyframes[i].pose.covariance.isApprox(
        circle.graph.keyframes[i].pose.covariance, 1e-9));
  }
}

}  // namespace
}  // namespace ceilmap::graph
