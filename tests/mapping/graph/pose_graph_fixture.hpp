#pragma once

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "mapping/graph/pose_graph.hpp"
#include "tests/mapping/graph/synthetic_graph.hpp"

/// Small pose graphs, and what they are checked with.
namespace ceilmap::graph {

using Ids = std::vector<std::int64_t>;

inline constexpr double kPi = std::numbers::pi;
inline const PoseGraphParams kPlain = {.loop_loss_scale = 0, .function_tolerance = 1e-15};

inline Edge MakeEdge(std::int64_t from, std::int64_t to, const Pose2& T_from_to) {
  Edge edge;
  edge.from = from;
  edge.to = to;
  edge.kind = to == from + 1 ? Edge::Kind::kOdometry : Edge::Kind::kLoopClosure;
  edge.T_from_to = T_from_to;
  return edge;
}

inline void ExpectPose(const Pose2& pose, const Pose2& expected, double tolerance) {
  EXPECT_NEAR(pose.x, expected.x, tolerance);
  EXPECT_NEAR(pose.y, expected.y, tolerance);
  EXPECT_NEAR(WrapAngle(pose.yaw - expected.yaw), 0, tolerance);
}

inline double MaxError(const std::vector<Pose2>& poses, const std::vector<Pose2>& truth) {
  double largest = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    largest = std::max(largest, (poses[i].Translation() - truth[i].Translation()).norm());
    largest = std::max(largest, std::abs(WrapAngle(poses[i].yaw - truth[i].yaw)));
  }
  return largest;
}

inline double Cost(const std::vector<Edge>& edges, const std::vector<Pose2>& poses) {
  double sum = 0;
  for (const Edge& edge : edges) sum += EdgeChi2(edge, poses[edge.from], poses[edge.to]) / 2;
  return sum;
}

inline Eigen::Matrix3d RandomInformation(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const Eigen::Matrix3d a = Eigen::Matrix3d::NullaryExpr([&] { return unit(random); });
  return 10 * a * a.transpose() + Eigen::Matrix3d::Identity();
}

/// A connected graph over random poses: an edge to an earlier keyframe for each, and as many again.
inline synthetic::World RandomWorld(int size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> normal;
  synthetic::World world;
  for (int i = 0; i < size; ++i) {
    world.truth.push_back({5 * unit(random), 5 * unit(random), kPi * unit(random)});
    const Pose2& truth = world.truth.back();
    world.graph.poses.push_back({truth.x + 0.1 * normal(random),
                                 truth.y + 0.1 * normal(random),
                                 truth.yaw + 0.05 * normal(random)});
  }
  const auto add = [&](int from, int to) {
    if (from == to) return;
    Edge edge = MakeEdge(from, to, world.truth[from].Inverse() * world.truth[to]);
    edge.information = RandomInformation(random);
    world.graph.edges.push_back(edge);
  };
  for (int i = 1; i < size; ++i) {
    std::uniform_int_distribution<int> earlier(0, i - 1);
    add(earlier(random), i);
    add(i, earlier(random));
  }
  world.graph.fixed = {0};
  world.graph.poses[0] = world.truth[0];
  return world;
}

/// J of all edges over all poses by central differences, of fourth order, of the public residual,
/// whitened.
inline Eigen::MatrixXd NumericJacobian(const std::vector<Edge>& edges,
                                       const std::vector<Pose2>& poses) {
  constexpr double kStep = 1e-3;
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(edges.size()),
                                                   3 * static_cast<Eigen::Index>(poses.size()));
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const Edge& edge = edges[e];
    const Eigen::Matrix3d whitening = edge.information.llt().matrixU();
    for (const std::int64_t moved : {edge.from, edge.to}) {
      for (int k = 0; k < 3; ++k) {
        const auto at = [&](double step) {
          Pose2 from = poses[edge.from];
          Pose2 to = poses[edge.to];
          Pose2& pose = moved == edge.from ? from : to;
          (k == 0 ? pose.x : k == 1 ? pose.y : pose.yaw) += step;
          return EdgeResidual(edge, from, to);
        };
        jacobian.block<3, 1>(3 * static_cast<Eigen::Index>(e), 3 * moved + k) =
            whitening * (8 * (at(kStep) - at(-kStep)) - (at(2 * kStep) - at(-2 * kStep))) /
            (12 * kStep);
      }
    }
  }
  return jacobian;
}

}  // namespace ceilmap::graph
