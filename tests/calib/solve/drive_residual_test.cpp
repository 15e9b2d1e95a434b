#include "calib/solve/drive_residual.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

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

/// Jacobians by central differences.
std::vector<Eigen::MatrixXd> Differences(const ceres::CostFunction& cost,
                                         std::vector<std::vector<double>> values) {
  std::vector<const double*> blocks;
  blocks.reserve(values.size());
  for (const auto& block : values) blocks.push_back(block.data());
  std::vector<Eigen::MatrixXd> jacobians;
  for (auto& block : values) {
    Eigen::MatrixXd jacobian(2, block.size());
    for (std::size_t i = 0; i < block.size(); ++i) {
      constexpr double kStep = 1e-5;
      const double at = block[i];
      Eigen::Vector2d above;
      Eigen::Vector2d below;
      block[i] = at + kStep;
      cost.Evaluate(blocks.data(), above.data(), nullptr);
      block[i] = at - kStep;
      cost.Evaluate(blocks.data(), below.data(), nullptr);
      block[i] = at;
      jacobian.col(static_cast<Eigen::Index>(i)) = (above - below) / (2 * kStep);
    }
    jacobians.push_back(jacobian);
  }
  return jacobians;
}

std::vector<Eigen::MatrixXd> Derivatives(const ceres::CostFunction& cost,
                                         const std::vector<std::vector<double>>& values) {
  using ByRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::vector<const double*> blocks;
  std::vector<ByRows> jacobians;
  for (const auto& block : values) {
    blocks.push_back(block.data());
    jacobians.emplace_back(2, block.size());
  }
  std::vector<double*> places;
  places.reserve(jacobians.size());
  for (ByRows& jacobian : jacobians) places.push_back(jacobian.data());
  Eigen::Vector2d residual;
  cost.Evaluate(blocks.data(), residual.data(), places.data());
  return {jacobians.begin(), jacobians.end()};
}

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
    const auto expected = Differences(*cost, values);
    const auto actual = Derivatives(*cost, values);
    ASSERT_EQ(actual.size(), point.height < 0 ? 3U : 4U);
    for (std::size_t k = 0; k < actual.size(); ++k) {
      EXPECT_LT((actual[k] - expected[k]).norm(), 1e-8 * (1 + expected[k].norm()))
          << "trial " << trial << ", block " << k << '\n'
          << actual[k] << "\nexpected\n"
          << expected[k];
    }
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
