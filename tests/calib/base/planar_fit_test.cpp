#include "calib/base/planar_fit.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>
#include <vector>

namespace ceilmap {
namespace {

TEST(Similarity2, TransformsByHand) {
  const Similarity2 S_a_b{{10, 20, std::numbers::pi / 2}, 2};
  const Eigen::Vector2d p_a = S_a_b * Eigen::Vector2d(3, 1);
  EXPECT_NEAR(p_a.x(), 8, 1e-12);   // 10 - 2 * 1
  EXPECT_NEAR(p_a.y(), 26, 1e-12);  // 20 + 2 * 3
  const Pose2 T_a_c = S_a_b * Pose2{3, 1, 0.5};
  EXPECT_NEAR(T_a_c.yaw, 0.5 + std::numbers::pi / 2, 1e-12);
  const Eigen::Vector2d back = S_a_b.Inverse() * p_a;
  EXPECT_NEAR(back.x(), 3, 1e-12);
  EXPECT_NEAR(back.y(), 1, 1e-12);
}

TEST(FitPlane, RecoversRandomTransforms) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const Similarity2 truth{{9 * unit(random), 9 * unit(random), 3.1 * unit(random)},
                            2 + unit(random)};
    std::vector<PointPair> pairs;
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d p_b(5 * unit(random), 5 * unit(random));
      pairs.push_back({truth * p_b, p_b, 2 + unit(random)});
    }
    const auto fit = FitPlane(pairs, true);
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->S_a_b.scale, truth.scale, 1e-12);
    EXPECT_NEAR(fit->S_a_b.motion.x, truth.motion.x, 1e-11);
    EXPECT_NEAR(fit->S_a_b.motion.y, truth.motion.y, 1e-11);
    EXPECT_NEAR(WrapAngle(fit->S_a_b.motion.yaw - truth.motion.yaw), 0, 1e-12);
  }
}

TEST(FitPlane, WeightsCountAsRepetitions) {
  const PointPair a{{0, 0}, {0, 0.3}};
  const PointPair b{{4, 0}, {4, 0}};
  PointPair twice{{0, 5}, {0.2, 5}};
  const auto repeated = FitPlane(std::vector<PointPair>{a, b, twice, twice}, true);
  twice.weight = 2;
  const auto weighted = FitPlane(std::vector<PointPair>{a, b, twice}, true);
  EXPECT_NEAR(repeated->S_a_b.motion.x, weighted->S_a_b.motion.x, 1e-12);
  EXPECT_NEAR(repeated->S_a_b.motion.yaw, weighted->S_a_b.motion.yaw, 1e-12);
  EXPECT_NEAR(repeated->S_a_b.scale, weighted->S_a_b.scale, 1e-12);
  EXPECT_EQ(weighted->weights, 4);
}

TEST(FitPlane, PointsInOnePlaceDetermineNothing) {
  EXPECT_FALSE(FitPlane(std::vector<PointPair>{{{1, 2}, {3, 4}}}, false));
  EXPECT_FALSE(FitPlane(std::vector<PointPair>{{{1, 2}, {3, 4}}, {{1, 2}, {5, 4}}}, true));
  EXPECT_FALSE(FitPlane(std::vector<PointPair>{{{1, 2}, {3, 4}}, {{7, 2}, {3, 4}}}, true));
}

}  // namespace
}  // namespace ceilmap
