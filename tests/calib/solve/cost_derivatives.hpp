#pragma once

#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

namespace ceilmap::calibration {

/// Jacobians by central differences.
inline std::vector<Eigen::MatrixXd> Differences(const ceres::CostFunction& cost,
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

inline std::vector<Eigen::MatrixXd> Derivatives(const ceres::CostFunction& cost,
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

/// Expects the derivatives of a cost function of two residuals by all its blocks.
inline void ExpectDerivatives(const ceres::CostFunction& cost,
                              const std::vector<std::vector<double>>& values) {
  const auto expected = Differences(cost, values);
  const auto actual = Derivatives(cost, values);
  for (std::size_t k = 0; k < actual.size(); ++k) {
    EXPECT_LT((actual[k] - expected[k]).norm(), 1e-8 * (1 + expected[k].norm()))
        << "block " << k << '\n'
        << actual[k] << "\nexpected\n"
        << expected[k];
  }
}

}  // namespace ceilmap::calibration
