#include "mapping/pose_graph.hpp"

#include <ceres/ceres.h>
#include <ceres/covariance.h>
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

#include "calib/error.hpp"
#include "tests/mapping/synthetic_graph.hpp"

namespace ceilmap::mapping {
namespace {

using Ids = std::vector<std::int64_t>;

constexpr double kPi = std::numbers::pi;
const PoseGraphParams kPlain = {.loop_loss_scale = 0, .function_tolerance = 1e-15};

Edge MakeEdge(std::int64_t from, std::int64_t to, const Pose2& T_from_to) {
  Edge edge;
  edge.from = from;
  edge.to = to;
  edge.kind = to == from + 1 ? Edge::Kind::kOdometry : Edge::Kind::kLoopClosure;
  edge.T_from_to = T_from_to;
  return edge;
}

void ExpectPose(const Pose2& pose, const Pose2& expected, double tolerance) {
  EXPECT_NEAR(pose.x, expected.x, tolerance);
  EXPECT_NEAR(pose.y, expected.y, tolerance);
  EXPECT_NEAR(calib::WrapAngle(pose.yaw - expected.yaw), 0, tolerance);
}

double MaxError(const std::vector<Pose2>& poses, const std::vector<Pose2>& truth) {
  double largest = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    largest = std::max(largest, (poses[i].Translation() - truth[i].Translation()).norm());
    largest = std::max(largest, std::abs(calib::WrapAngle(poses[i].yaw - truth[i].yaw)));
  }
  return largest;
}

double Cost(const std::vector<Edge>& edges, const std::vector<Pose2>& poses) {
  double sum = 0;
  for (const Edge& edge : edges) sum += EdgeChi2(edge, poses[edge.from], poses[edge.to]) / 2;
  return sum;
}

Eigen::Matrix3d RandomInformation(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const Eigen::Matrix3d a = Eigen::Matrix3d::NullaryExpr([&] { return unit(random); });
  return 10 * a * a.transpose() + Eigen::Matrix3d::Identity();
}

/// A connected graph over random poses: an edge to an earlier keyframe for each, and as many again.
synthetic::World RandomWorld(int size, std::uint32_t seed) {
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
Eigen::MatrixXd NumericJacobian(const std::vector<Edge>& edges, const std::vector<Pose2>& poses) {
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
    truth.push_back({std::sin(yaw), 1 - std::cos(yaw), calib::WrapAngle(yaw)});
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
    truth.push_back({20 * std::sin(yaw), 20 - 20 * std::cos(yaw), calib::WrapAngle(yaw)});
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
  } catch (const calib::InputError& error) {
    message = error.what();
  }
  try {
    MarginalCovariances(edges, fixed, poses);
  } catch (const calib::InputError& error) {
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
    } catch (const calib::InputError& error) {
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

TEST(MarginalCovariances, ChainByHand) {
  // Two steps of 1 m along x: the first's error in yaw moves the second's end sideways.
  std::vector<Edge> edges = {MakeEdge(0, 1, {1, 0, 0}), MakeEdge(1, 2, {1, 0, 0})};
  for (Edge& edge : edges) edge.information = Eigen::Vector3d(100, 25, 400).asDiagonal();
  const std::vector<Pose2> poses = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const auto covariances = MarginalCovariances(edges, Ids{0}, poses);
  ASSERT_EQ(covariances.size(), 3U);
  EXPECT_EQ(covariances[0], Eigen::Matrix3d::Zero());
  const Eigen::Matrix3d one = Eigen::Vector3d(0.01, 0.04, 0.0025).asDiagonal();
  EXPECT_LT((covariances[1] - one).norm(), 1e-15);
  Eigen::Matrix3d two;
  two << 0.02, 0, 0, 0, 0.08 + 0.0025, 0.0025, 0, 0.0025, 0.005;
  EXPECT_LT((covariances[2] - two).norm(), 1e-15);
}

TEST(MarginalCovariances, AreInMapAxes) {
  // Facing +y, sigma along the way is sigma of y.
  Edge edge = MakeEdge(0, 1, {1, 0, 0});
  edge.information = Eigen::Vector3d(100, 25, 400).asDiagonal();
  const std::vector<Pose2> poses = {{0, 0, kPi / 2}, {0, 1, kPi / 2}};
  const auto covariances = MarginalCovariances(std::vector<Edge>{edge}, Ids{0}, poses);
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.04, 0.01, 0.0025).asDiagonal();
  EXPECT_LT((covariances[1] - expected).norm(), 1e-15);
}

/// Largest difference of the blocks, as a part of the expected.
double RelativeError(const Eigen::Matrix3d& value, const Eigen::Matrix3d& expected) {
  return (value - expected).norm() / expected.norm();
}

TEST(MarginalCovariances, AgreeWithTheDenseInverse) {
  for (const int size : {2, 3, 10, 150}) {
    const synthetic::World world = RandomWorld(size, 10);
    const std::vector<Edge>& edges = world.graph.edges;
    const Ids fixed = size > 5 ? Ids{0, 4} : Ids{0};
    const auto covariances = MarginalCovariances(edges, fixed, world.truth, kPlain);
    const Eigen::MatrixXd jacobian = NumericJacobian(edges, world.truth);
    Eigen::MatrixXd information = jacobian.transpose() * jacobian;
    for (const std::int64_t id : fixed) {
      information.middleRows(3 * id, 3).setZero();
      information.middleCols(3 * id, 3).setZero();
      information.block<3, 3>(3 * id, 3 * id).setIdentity();
    }
    const Eigen::MatrixXd inverse = information.inverse();
    for (int i = 0; i < size; ++i) {
      if (std::count(fixed.begin(), fixed.end(), i) > 0) {
        EXPECT_EQ(covariances[i], Eigen::Matrix3d::Zero());
        continue;
      }
      EXPECT_LT(RelativeError(covariances[i], inverse.block<3, 3>(3 * i, 3 * i)), 1e-9);
      EXPECT_EQ(covariances[i], covariances[i].transpose());
    }
  }
}

struct AutoDiffResidual {
  Edge edge;

  template <typename T>
  bool operator()(const T* from, const T* to, T* residual) const {
    using std::cos;
    using std::sin;
    const T dx = to[0] - from[0];
    const T dy = to[1] - from[1];
    const Eigen::Matrix<T, 3, 1> error(cos(from[2]) * dx + sin(from[2]) * dy - edge.T_from_to.x,
                                       cos(from[2]) * dy - sin(from[2]) * dx - edge.T_from_to.y,
                                       to[2] - from[2] - edge.T_from_to.yaw);
    const Eigen::Matrix3d whitening = edge.information.llt().matrixU();
    Eigen::Map<Eigen::Matrix<T, 3, 1>>{residual} = whitening.cast<T>() * error;
    return true;
  }
};

TEST(MarginalCovariances, AgreeWithCeres) {
  const synthetic::World world = synthetic::Lawnmower(8, 12, 3);
  std::vector<std::array<double, 3>> blocks;
  for (const Pose2& pose : world.truth) blocks.push_back({pose.x, pose.y, pose.yaw});
  ceres::Problem problem;
  for (const Edge& edge : world.graph.edges) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<AutoDiffResidual, 3, 3, 3>(new AutoDiffResidual{edge}),
        nullptr,
        blocks[edge.from].data(),
        blocks[edge.to].data());
  }
  problem.SetParameterBlockConstant(blocks[0].data());
  std::vector<std::pair<const double*, const double*>> wanted;
  for (const auto& block : blocks) wanted.emplace_back(block.data(), block.data());
  ceres::Covariance ceres_covariance({});
  ASSERT_TRUE(ceres_covariance.Compute(wanted, &problem));
  const auto covariances =
      MarginalCovariances(world.graph.edges, world.graph.fixed, world.truth, kPlain);
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> expected;
    ceres_covariance.GetCovarianceBlock(blocks[i].data(), blocks[i].data(), expected.data());
    EXPECT_LT(RelativeError(covariances[i], expected), 1e-9);
  }
}

TEST(MarginalCovariances, UnknownWhereNothingFixedIsJoined) {
  const std::vector<Edge> edges = {MakeEdge(0, 1, {1, 0, 0}), MakeEdge(2, 3, {1, 0, 0})};
  const auto covariances = MarginalCovariances(edges, Ids{1, 4}, std::vector<Pose2>(6));
  const double infinity = std::numeric_limits<double>::infinity();
  const Eigen::Matrix3d unknown = Eigen::Vector3d::Constant(infinity).asDiagonal();
  EXPECT_TRUE(covariances[0].allFinite());
  EXPECT_EQ(covariances[1], Eigen::Matrix3d::Zero());
  EXPECT_EQ(covariances[2], unknown);
  EXPECT_EQ(covariances[3], unknown);
  EXPECT_EQ(covariances[4], Eigen::Matrix3d::Zero());
  EXPECT_EQ(covariances[5], unknown);
}

TEST(MarginalCovariances, AFalseClosureAddsNoTrust) {
  std::vector<Edge> edges = {MakeEdge(0, 1, {1, 0, 0}), MakeEdge(1, 2, {1, 0, 0})};
  const std::vector<Pose2> poses = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const auto without = MarginalCovariances(edges, Ids{0}, poses);
  edges.push_back(MakeEdge(0, 2, {1000, 0, 0}));
  const auto robust = MarginalCovariances(edges, Ids{0}, poses);
  const auto plain = MarginalCovariances(edges, Ids{0}, poses, kPlain);
  EXPECT_LT(RelativeError(robust[2], without[2]), 1e-6);
  EXPECT_LT(plain[2].norm(), 0.7 * without[2].norm());
}

}  // namespace
}  // namespace ceilmap::mapping
