#include "calib/solve/pair_problem.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

namespace ceilmap::calibration {
namespace {

/// Two residuals that state two parameters.
struct States {
  double x;
  double y;
  template <typename T>
  bool operator()(const T* p, T* residual) const {
    residual[0] = p[0] - x;
    residual[1] = 2.0 * p[1] - y;
    return true;
  }
};

class PairProblemTest : public testing::Test {
 protected:
  void Add(double x, double y, int first, int second, bool place = true) {
    const auto id = problem_.problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<States, 2, 2>(new States{x, y}),
        place ? new ceres::CauchyLoss(kCauchy) : nullptr,
        parameters_.data());
    problem_.owners.push_back({id, first, second, place});
    problem_.blocks = {parameters_.data()};
  }

  std::array<double, 2> parameters_{};
  PairProblem problem_;
};

TEST_F(PairProblemTest, MinimisesUnderTheLoss) {
  for (const double x : {0.9, 1.0, 1.1, 1.0, 1000.0}) Add(x, 2 * x, 0, 1);
  ASSERT_TRUE(Minimise(problem_, 50));
  EXPECT_NEAR(parameters_[0], 1, 0.02);
  EXPECT_NEAR(parameters_[1], 1, 0.02);
}

TEST_F(PairProblemTest, LinearizesWithoutTheLoss) {
  Add(-30, 4, 0, 1);
  const Linearized at(problem_);
  ASSERT_EQ(at.residuals.size(), 2U);
  EXPECT_EQ(at.residuals[0], 30);
  EXPECT_EQ(at.residuals[1], -4);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, 2);
  AddOuter(at.jacobian, 0, 1, H);
  AddOuter(at.jacobian, 1, 0.5, H);
  EXPECT_EQ(H, Eigen::Vector2d(1, 2).asDiagonal().toDenseMatrix());
}

TEST_F(PairProblemTest, WeightsAreDerivativesOfTheLoss) {
  Add(-3, 1, 0, 1);
  Add(-3, 1, 0, -1, false);
  const Linearized at(problem_);
  const BlockTerm term = TermOf(problem_.owners[0], at, 0, problem_.problem);
  EXPECT_EQ(term.rows, 2);
  std::array<double, 3> rho{};  // of the squared residual, and its derivatives
  ceres::CauchyLoss(kCauchy).Evaluate(10, rho.data());
  EXPECT_NEAR(term.weight, rho[1], 1e-12);
  EXPECT_NEAR(term.bend, 2 * rho[2], 1e-12);
  const BlockTerm plain = TermOf(problem_.owners[1], at, 2, problem_.problem);
  EXPECT_EQ(plain.rows, 2);
  EXPECT_EQ(plain.weight, 1);
  EXPECT_EQ(plain.bend, 0);
}

TEST_F(PairProblemTest, BlocksOfAPairAreOneInfluence) {
  Add(1, 0, 0, 1, false);
  Add(2, 0, 0, 1, false);
  Add(4, 0, 1, 2, false);
  Add(8, 3, 2, -1, false);
  const Linearized at(problem_);
  Eigen::MatrixXd influence(3, 2);
  influence << 1, 0, 0, 1, 10, 100;
  const std::vector<PairInfluence> pairs = InfluenceOfPairs(problem_, at, influence);
  ASSERT_EQ(pairs.size(), 3U);
  EXPECT_EQ(pairs[0].first, 0);
  EXPECT_EQ(pairs[0].second, 1);
  EXPECT_EQ(pairs[0].change, Eigen::Vector3d(-3, 0, -30));
  EXPECT_EQ(pairs[1].change, Eigen::Vector3d(-4, 0, -40));
  EXPECT_EQ(pairs[2].second, -1);
  EXPECT_EQ(pairs[2].change, Eigen::Vector3d(-8, -6, -680));
}

}  // namespace
}  // namespace ceilmap::calibration
