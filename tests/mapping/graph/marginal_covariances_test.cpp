#include <ceres/ceres.h>
#include <ceres/covariance.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/mapping/graph/pose_graph_fixture.hpp"

namespace ceilmap::graph {
namespace {

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
  // Facing +y, sigma along the path is sigma of y.
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

/// Of the errors of all keyframes, dense, from the marginal case with the anchor fixed.
Eigen::MatrixXd DenseCovariance(const std::vector<Edge>& edges,
                                std::int64_t anchor,
                                const std::vector<Pose2>& poses) {
  const Eigen::MatrixXd jacobian = NumericJacobian(edges, poses);
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  information.middleRows(3 * anchor, 3).setZero();
  information.middleCols(3 * anchor, 3).setZero();
  information.block<3, 3>(3 * anchor, 3 * anchor).setIdentity();
  Eigen::MatrixXd covariance = information.inverse();
  covariance.block<3, 3>(3 * anchor, 3 * anchor).setZero();
  return covariance;
}

TEST(GaugeFreeCovariances, AreWhatAFitOfThePositionsLeaves) {
  constexpr int kSize = 25;
  const synthetic::World world = RandomWorld(kSize, 10);
  const std::vector<Edge>& edges = world.graph.edges;
  const std::vector<Pose2>& poses = world.truth;
  const auto shape = GaugeFreeCovariances(edges, 0, poses, kPlain);
  ASSERT_EQ(shape.size(), poses.size());
  // Projector: subtract the planar motion with the least squared error of the positions.
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (const Pose2& pose : poses) centroid += pose.Translation() / kSize;
  Eigen::MatrixXd motions(3 * kSize, 3);
  Eigen::MatrixXd positions = Eigen::MatrixXd::Zero(3 * kSize, 3);
  for (int i = 0; i < kSize; ++i) {
    const Eigen::Vector2d arm = poses[static_cast<std::size_t>(i)].Translation() - centroid;
    motions.block<3, 3>(3 * i, 0) << 1, 0, -arm.y(), 0, 1, arm.x(), 0, 0, 1;
    positions.block<2, 3>(3 * i, 0) = motions.block<2, 3>(3 * i, 0);
  }
  const Eigen::MatrixXd fit = (positions.transpose() * positions).inverse() * positions.transpose();
  const Eigen::MatrixXd project = Eigen::MatrixXd::Identity(3 * kSize, 3 * kSize) - motions * fit;
  const Eigen::MatrixXd expected = project * DenseCovariance(edges, 0, poses) * project.transpose();
  for (int i = 0; i < kSize; ++i) {
    const Eigen::Matrix3d block = expected.block<3, 3>(3 * i, 3 * i);
    EXPECT_LT(RelativeError(shape[static_cast<std::size_t>(i)], block), 1e-5) << i;
  }
}

TEST(GaugeFreeCovariances, DoNotDependOnTheAnchor) {
  const synthetic::World world = RandomWorld(40, 10);
  const auto a = GaugeFreeCovariances(world.graph.edges, 0, world.truth, kPlain);
  const auto b = GaugeFreeCovariances(world.graph.edges, 23, world.truth, kPlain);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT(RelativeError(a[i], b[i]), 1e-6) << i;
}

TEST(GaugeFreeCovariances, WhatIsNotConnectedIsUnknown) {
  const std::vector<Edge> edges = {MakeEdge(0, 1, {1, 0, 0}), MakeEdge(2, 3, {1, 0, 0})};
  const std::vector<Pose2> apart = {{0, 0, 0}, {1, 0, 0}, {5, 0, 0}, {6, 0, 0}};
  const auto shape = GaugeFreeCovariances(edges, 0, apart, kPlain);
  EXPECT_TRUE(shape[0].allFinite());
  EXPECT_TRUE(shape[1].allFinite());
  EXPECT_FALSE(shape[2].allFinite());
}

}  // namespace
}  // namespace ceilmap::graph
