#include "calib/solve/drive_residual.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

#include "tests/calib/solve/cost_derivatives.hpp"

namespace ceilmap::calibration {
namespace {

/// A residual with random values of everything that it depends on.
class DriveResidualTest : public testing::Test {
 protected:
  DrivePoint RandomPoint(int height) {
    DrivePoint point;
    for (LevelRay* ray : {&point.at_first, &point.at_second}) {
      ray->slope = Random<2, 1>(0.5);
      ray->by_lens = Random<2, 3>(0.3);
      ray->row = Random<1, 1>(0.3)(0);
      ray->velocity.linear = Random<2, 1>(0.4);
      ray->velocity.yaw_rad_s = Random<1, 1>(0.5)(0);
    }
    point.height = height;
    return point;
  }

  template <int kRows, int kCols>
  Eigen::Matrix<double, kRows, kCols> Random(double sigma) {
    std::normal_distribution<double> normal(0, sigma);
    return Eigen::Matrix<double, kRows, kCols>::NullaryExpr([&] { return normal(random_); });
  }

  std::mt19937 random_{11};
};

TEST_F(DriveResidualTest, DerivativesAreThoseOfTheResidual) {
  for (int trial = 0; trial < 40; ++trial) {
    const DrivePoint point = RandomPoint(trial % 2 - 1);
    const std::unique_ptr<ceres::CostFunction> cost(NewPointCost(point, Random<2, 2>(1)));
    std::vector<std::vector<double>> values;
    for (const int size : cost->parameter_block_sizes()) {
      std::vector<double>& block = values.emplace_back();
      for (int i = 0; i < size; ++i) block.push_back(Random<1, 1>(0.2)(0));
    }
    if (trial < 4) values[0][kCameraTiltX] = values[0][kCameraTiltY] = 0;  // a level camera
    ASSERT_EQ(values.size(), point.height < 0 ? 3U : 4U);
    ExpectDerivatives(*cost, values);
  }
}

TEST_F(DriveResidualTest, APointWhereItIsHasNoError) {
  const Eigen::Vector2d place(0.7, -0.4);  // on the ceiling, in units of Z
  const std::array<double, 3> first{0.1, 0.2, 0.3};
  const std::array<double, 3> second{0.5, -0.1, 0.3 + std::numbers::pi / 2};
  const auto slope = [&](const std::array<double, 3>& camera) -> Eigen::Vector2d {
    return Eigen::Rotation2Dd(-camera[2]) * (place - Eigen::Vector2d(camera[0], camera[1]));
  };
  DrivePoint point;
  point.at_first.slope = slope(first);
  point.at_second.slope = slope(second);
  const std::array<double, kCameraErrors> none{};
  const DriveState state{none.data(), first.data(), second.data(), 1};
  EXPECT_LT(ErrorOf(point, state, nullptr).norm(), 1e-15);
}

}  // namespace
}  // namespace ceilmap::calibration
