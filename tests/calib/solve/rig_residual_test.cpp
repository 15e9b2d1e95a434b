#include "calib/solve/rig_residual.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <memory>
#include <random>
#include <vector>

#include "tests/calib/solve/cost_derivatives.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Vector2d;

TEST(RigResidual, DerivativesAreThoseOfTheResidual) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 0.3);
  const auto vector = [&]() -> Vector2d { return {normal(random), normal(random)}; };
  for (int trial = 0; trial < 40; ++trial) {
    PointCorrespondence place;
    place.first = vector();
    place.second = vector();
    place.first_row = normal(random);
    place.second_row = normal(random);
    const PlaceSights sights{&place, {vector(), normal(random)}, {vector(), normal(random)}};
    Eigen::Matrix2d weight;
    weight << vector(), vector();
    const std::unique_ptr<ceres::CostFunction> cost(NewPlaceCost(sights, weight));
    std::vector<std::vector<double>> values;
    for (const int size : cost->parameter_block_sizes()) {
      std::vector<double>& block = values.emplace_back();
      for (int i = 0; i < size; ++i) block.push_back(normal(random));
    }
    if (trial < 4) values[0] = {0, 0};  // a level camera
    ExpectDerivatives(*cost, values);
  }
}

TEST(RigResidual, APointWhereItIsHasNoError) {
  const Vector2d point(0.7, -0.4);  // on the ceiling, in units of Z
  const std::array<double, 2> level{};
  const std::array<double, 2> centre{0.2, 0.1};
  const std::array<double, 3> first{0.1, 0.2, 0.3};
  const std::array<double, 3> second{0.5, -0.1, 1.9};
  const auto ray = [&](const std::array<double, 3>& robot) -> Vector2d {
    return Eigen::Rotation2Dd(-robot[2]) * (point - Vector2d(robot[0], robot[1])) -
           Vector2d(centre[0], centre[1]);
  };
  PointCorrespondence place;
  place.first = ray(first);
  place.second = ray(second);
  const PlaceState state{level.data(), centre.data(), 0, first.data(), second.data()};
  EXPECT_LT(PlaceDifference({&place, {}, {}}, state, nullptr).norm(), 1e-15);
}

}  // namespace
}  // namespace ceilmap::calibration
