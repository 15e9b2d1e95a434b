#include "mapping/graph/pose_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/error.hpp"
#include "tests/mapping/graph/pose_graph_fixture.hpp"

namespace ceilmap::graph {
namespace {

TEST(EdgeResidual, ByHand) {
  // From (1, 2) facing +y, a point 3 ahead and 1 to the left is (0, 5) on the map.
  Edge edge = MakeEdge(0, 1, {2.5, 1.25, 0.1});
  const Pose2 from = {1, 2, kPi / 2};
  const Pose2 to = {0, 5, kPi / 2 + 0.3};
  EXPECT_LT((EdgeResidual(edge, from, to) - Eigen::Vector3d(0.5, -0.25, 0.2)).norm(), 1e-15);
  edge.information = Eigen::Vector3d(4, 16, 100).asDiagonal();
  edge.information(0, 1) = edge.information(1, 0) = 2;
  EXPECT_NEAR(EdgeChi2(edge, from, to), 1 + 1 + 4 - 2 * 2 * 0.5 * 0.25, 1e-12);
}

TEST(EdgeResidual, YawWrapsAtHalfATurn) {
  const Edge edge = MakeEdge(0, 1, {0, 0, 3.1});
  EXPECT_NEAR(EdgeResidual(edge, {0, 0, 3.0}, {0, 0, -0.2}).z(), 2 * kPi - 6.3, 1e-12);
}

TEST(OptimizePoses, SquareSharesOutTheGap) {
  // Four sides of 1 m, the third measured 0.4 m too long; turns are certain. All four measurements
  // are equally good in x and y, so that each takes a quarter of the gap along x.
  std::vector<Edge> edges;
  for (int i = 0; i < 4; ++i) {
    edges.push_back(MakeEdge(i, (i + 1) % 4, {i == 2 ? 1.4 : 1, 0, kPi / 2}));
    edges.back().information(2, 2) = 1e12;
  }
  std::vector<Pose2> poses = {{0, 0, 0}, {1, 0, kPi / 2}, {1, 1, kPi}, {-0.4, 1, -kPi / 2}};
  const PoseGraphSummary summary = OptimizePoses(edges, Ids{0}, poses, kPlain);
  EXPECT_TRUE(summary.converged);
  ExpectPose(poses[0], {0, 0, 0}, 0);
  ExpectPose(poses[1], {1.1, 0, kPi / 2}, 1e-9);
  ExpectPose(poses[2], {1.2, 1, kPi}, 1e-9);
  ExpectPose(poses[3], {-0.1, 1, -kPi / 2}, 1e-9);
  EXPECT_NEAR(summary.initial_cost, 0.5 * 0.16, 1e-12);
  EXPECT_NEAR(summary.final_cost, 0.5 * 4 * 0.01, 1e-9);
}

TEST(OptimizePoses, WeighsByInformation) {
  // 1 m with information 1, 2 m with information 3.
  std::vector<Edge> edges = {MakeEdge(0, 1, {1, 0, 0}), MakeEdge(0, 1, {2, 0, 0})};
  edges[1].information *= 3;
  std::vector<Pose2> poses(2);
  OptimizePoses(edges, Ids{0}, poses, kPlain);
  ExpectPose(poses[1], {1.75, 0, 0}, 1e-9);
  // Backwards: the edge from 1 to 0.
  edges[1].from = 1;
  edges[1].to = 0;
  edges[1].T_from_to = {-2, 0, 0};
  poses = std::vector<Pose2>(2);
  OptimizePoses(edges, Ids{0}, poses, kPlain);
  ExpectPose(poses[1], {1.75, 0, 0}, 1e-9);
}

TEST(OptimizePoses, ConsistentEdgesGiveTheTruth) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const synthetic::World world = RandomWorld(5 + 5 * static_cast<int>(seed), seed);
    for (const double scale : {0.0, 3.0}) {
      PoseGraphParams params = kPlain;
      params.loop_loss_scale = params.odometry_loss_scale = scale;
      std::vector<Pose2> poses = world.graph.poses;
      const PoseGraphSummary summary =
          OptimizePoses(world.graph.edges, world.graph.fixed, poses, params);
      EXPECT_LT(MaxError(poses, world.truth), 1e-9) << "seed " << seed << ", scale " << scale;
      EXPECT_LT(summary.final_cost, 1e-15);
    }
  }
}

TEST(OptimizePoses, GradientVanishesAtTheOptimum) {
  // Against the numeric Jacobian: a wrong analytic one would stop elsewhere.
  synthetic::World world = RandomWorld(30, 1);
  for (Edge& edge : world.graph.edges) edge.T_from_to.x += 0.05;
  std::vector<Pose2> poses = world.graph.poses;
  const PoseGraphSummary summary =
      OptimizePoses(world.graph.edges, world.graph.fixed, poses, kPlain);
  EXPECT_NEAR(summary.final_cost, Cost(world.graph.edges, poses), 1e-9 * summary.final_cost);
  const Eigen::MatrixXd jacobian = NumericJacobian(world.graph.edges, poses);
  Eigen::VectorXd residual(jacobian.rows());
  for (Eigen::Index e = 0; e < jacobian.rows() / 3; ++e) {
    const Edge& edge = world.graph.edges[e];
    residual.segment<3>(3 * e) = edge.information.llt().matrixU().toDenseMatrix() *
                                 EdgeResidual(edge, poses[edge.from], poses[edge.to]);
  }
  const Eigen::VectorXd gradient = (jacobian.transpose() * residual).tail(jacobian.cols() - 3);
  const double size = (jacobian.cwiseAbs().transpose() * residual.cwiseAbs()).maxCoeff();
  EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-6 * size);
  EXPECT_LE(summary.iterations, 8);
}

TEST(OptimizePoses, YawAcrossHalfATurn) {
  // A full circle of eight, so that the yaws pass pi; the start is off by whole turns as well.
  std::vector<Pose2> truth;
  std::vector<Pose2> poses;
  std::vector<Edge> edges;
  for (int i = 0; i < 8; ++i) {
    const double yaw = 2 * kPi * i / 8;
    truth.push_back({std::sin(yaw), 1 - std::cos(yaw), WrapAngle(yaw)});
    poses.push_back(
        {truth[i].x + 0.05, truth[i].y - 0.05, truth[i].yaw + 0.05 + 4 * kPi * (i % 2)});
  }
  poses[0] = truth[0];
  for (int i = 0; i < 8; ++i) {
    edges.push_back(MakeEdge(i, (i + 1) % 8, truth[i].Inverse() * truth[(i + 1) % 8]));
  }
  OptimizePoses(edges, Ids{0}, poses, kPlain);
  EXPECT_LT(MaxError(poses, truth), 1e-9);
  for (const Pose2& pose : poses) {
    EXPECT_GT(pose.yaw, -kPi);
    EXPECT_LE(pose.yaw, kPi);
  }
}

TEST(OptimizePoses, FalseClosuresLeaveTheTruth) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    synthetic::World world = synthetic::Lawnmower(12, 20, seed);
    std::vector<Pose2> right = world.graph.poses;
    OptimizePoses(world.graph.edges, world.graph.fixed, right, kPlain);
    std::mt19937 random(seed + 100);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::uniform_int_distribution<std::int64_t> any(0, 239);
    const std::size_t closures = world.graph.edges.size() - 239;
    for (std::size_t i = 0; i < closures / 4; ++i) {  // 20 % of all closures
      Edge edge = world.graph.edges.back();
      edge.from = any(random);
      edge.to = (edge.from + 20 + any(random) % 200) % 240;
      edge.T_from_to = {unit(random), unit(random), 3 * unit(random)};
      world.graph.edges.push_back(edge);
    }
    std::vector<Pose2> poses = world.graph.poses;
    EXPECT_TRUE(OptimizePoses(world.graph.edges, world.graph.fixed, poses).converged);
    EXPECT_LT(MaxError(poses, right), 0.01) << "seed " << seed;
    poses = world.graph.poses;
    OptimizePoses(world.graph.edges, world.graph.fixed, poses, kPlain);
    EXPECT_GT(MaxError(poses, right), 1) << "plain squares should not have stood that";
  }
}

TEST(OptimizePoses, ClosesALoopThatHasDriftedFar) {
  // 400 keyframes around a circle; the drift is hundreds of the closures' sigmas.
  constexpr int kSize = 400;
  std::mt19937 random(1);
  std::vector<Pose2> truth;
  for (int i = 0; i < kSize; ++i) {
    const double yaw = 2 * kPi * i / (kSize - 5);
    truth.push_back({20 * std::sin(yaw), 20 - 20 * std::cos(yaw), WrapAngle(yaw)});
  }
  synthetic::World world = synthetic::Drive(truth, {0.02, 0.004}, random);
  for (int i = 0; i < 5; ++i) {
    const int seen_again = kSize - 5 + i;
    world.graph.edges.push_back(
        synthetic::MeasuredEdge(i, seen_again, truth, {0.003, 0.001}, random));
  }
  const Edge& closure = world.graph.edges.back();
  std::vector<Pose2> poses = world.graph.poses;
  ASSERT_GT(EdgeChi2(closure, poses[closure.from], poses[closure.to]), 200 * 200);
  EXPECT_TRUE(OptimizePoses(world.graph.edges, world.graph.fixed, poses).converged);
  EXPECT_LT(EdgeChi2(closure, poses[closure.from], poses[closure.to]), 20);
}

TEST(OptimizePoses, AWindowMovesAlone) {
  synthetic::World world = RandomWorld(60, 4);
  std::vector<Edge> window;  // chain 20 ... 30, its ends held
  for (int i = 20; i < 30; ++i) {
    window.push_back(MakeEdge(i, i + 1, world.truth[i].Inverse() * world.truth[i + 1]));
  }
  std::vector<Pose2> poses = world.graph.poses;
  poses[20] = world.truth[20];
  poses[30] = world.truth[30];
  poses[50].x = std::numeric_limits<double>::quiet_NaN();  // none of the window's business
  const std::vector<Pose2> before = poses;
  OptimizePoses(window, Ids{20, 30, 40}, poses, kPlain);
  for (int i = 0; i < 60; ++i) {
    if (i > 20 && i < 30) {
      ExpectPose(poses[i], world.truth[i], 1e-9);
    } else if (i != 50) {
      ExpectPose(poses[i], before[i], 0);
    }
  }
}

TEST(OptimizePoses, APartWithNothingFixedKeepsItsFirst) {
  const std::vector<Edge> edges = {
      MakeEdge(1, 0, {1, 0, 0}), MakeEdge(4, 3, {1, 0, 0}), MakeEdge(4, 5, {0, 2, 0})};
  std::vector<Pose2> poses = {{9, 9, 0}, {0, 0, 0}, {7, 7, 7}, {5, 5, kPi / 2}, {}, {}};
  OptimizePoses(edges, Ids{1}, poses, kPlain);
  ExpectPose(poses[0], {1, 0, 0}, 1e-9);
  ExpectPose(poses[1], {0, 0, 0}, 0);
  ExpectPose(poses[2], {7, 7, 7}, 0);
  ExpectPose(poses[3], {5, 5, kPi / 2}, 0);
  ExpectPose(poses[4], {5, 4, kPi / 2}, 1e-9);
  ExpectPose(poses[5], {3, 4, kPi / 2}, 1e-9);
}

TEST(OptimizePoses, NothingToDo) {
  std::vector<Pose2> poses = {{1, 2, 3}, {4, 5, 6}};
  EXPECT_TRUE(OptimizePoses({}, Ids{0}, poses).converged);
  const std::vector<Edge> edges = {MakeEdge(0, 1, {})};
  const PoseGraphSummary summary = OptimizePoses(edges, Ids{0, 1}, poses, kPlain);
  EXPECT_TRUE(summary.converged);
  EXPECT_NEAR(summary.final_cost, Cost(edges, poses), 1e-12);
  EXPECT_EQ(poses[1].yaw, 6);
}

/// The message that a graph of three keyframes with this edge is refused with, by both functions.
std::string Refusal(const Edge& edge, const Ids& fixed = {0}, const Pose2& third = {}) {
  std::vector<Pose2> poses(3);
  poses[2] = third;
  const std::vector<Edge> edges = {MakeEdge(0, 2, {}), edge};
  std::string message = "accepted";
  try {
    OptimizePoses(edges, fixed, poses);
  } catch (const InputError& error) {
    message = error.what();
  }
  try {
    MarginalCovariances(edges, fixed, poses);
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), message);
  }
  return message;
}

TEST(PoseGraph, RefusesWhatCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string range = ", must be from 0 to 2 (3 keyframes)";
  EXPECT_EQ(Refusal(MakeEdge(0, 1, {})), "accepted");
  EXPECT_EQ(Refusal(MakeEdge(-1, 1, {})), "pose graph: edge from keyframe -1" + range);
  EXPECT_EQ(Refusal(MakeEdge(0, 3, {})), "pose graph: edge to keyframe 3" + range);
  EXPECT_EQ(Refusal(MakeEdge(0, 1, {}), {5}), "pose graph: fixed keyframe 5" + range);
  EXPECT_EQ(Refusal(MakeEdge(1, 1, {})), "pose graph: edge from keyframe 1 to itself");
  EXPECT_EQ(Refusal(MakeEdge(0, 1, {0, nan, 0})),
            "pose graph: edge 0 -> 1: the motion is not finite");
  EXPECT_EQ(Refusal(MakeEdge(0, 1, {}), {0}, {nan, 0, 0}),
            "pose graph: the pose of keyframe 2 is not finite");
}

TEST(PoseGraph, RefusesInformationThatIsNone) {
  const std::string refusal =
      "pose graph: edge 0 -> 1: the information is not symmetric and positive definite";
  Edge edge = MakeEdge(0, 1, {});
  edge.information(1, 1) = 0;
  EXPECT_EQ(Refusal(edge), refusal);
  edge.information(1, 1) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Refusal(edge), refusal);
  edge.information = Eigen::Matrix3d::Identity();
  edge.information(0, 2) = 0.1;
  EXPECT_EQ(Refusal(edge), refusal);
  edge.information.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(Refusal(edge), refusal);
}

TEST(PoseGraphParams, RefusesWhatCannotBe) {
  std::vector<Pose2> poses;
  const auto refusal = [&poses](const PoseGraphParams& params) -> std::string {
    try {
      OptimizePoses({}, {}, poses, params);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal({}), "accepted");
  EXPECT_EQ(refusal({.loop_loss_scale = -1}),
            "pose graph: loop_loss_scale = -1, must be at least 0");
  EXPECT_EQ(refusal({.odometry_loss_scale = -1}),
            "pose graph: odometry_loss_scale = -1, must be at least 0");
  EXPECT_EQ(refusal({.max_iterations = 0}), "pose graph: max_iterations = 0, must be at least 1");
  EXPECT_EQ(refusal({.function_tolerance = 0}),
            "pose graph: function_tolerance = 0, must be in (0, 1)");
  EXPECT_EQ(refusal({.threads = -1}), "pose graph: threads = -1, must be at least 0");
}

}  // namespace
}  // namespace ceilmap::graph
