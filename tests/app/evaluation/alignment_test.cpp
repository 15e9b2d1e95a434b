#include "app/evaluation/alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::evaluation {
namespace {

TEST(FitPlanarMotion, RecoversAMotion) {
  const Pose2 T{3, -4, 2.9};
  std::vector<PointPair> pairs;
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0.5), Eigen::Vector2d(-2, 1)}) {
    pairs.push_back({T * p, p});
  }
  const Pose2 fit = FitPlanarMotion(pairs);
  EXPECT_NEAR(fit.x, T.x, 1e-14);
  EXPECT_NEAR(fit.y, T.y, 1e-14);
  EXPECT_NEAR(fit.yaw, T.yaw, 1e-14);
}

TEST(FitPlanarMotion, OnePlaceIsOnlyMoved) {
  const Pose2 fit = FitPlanarMotion({{{1, 2}, {5, 5}}, {{1, 2}, {5, 5}}});
  EXPECT_EQ(fit.Translation(), Eigen::Vector2d(-4, -3));
  EXPECT_EQ(fit.yaw, 0);
}

TEST(FitPlanarSimilarity, RecoversAScale) {
  const Similarity2 T{{3, -4, 2.9}, 0.05};
  std::vector<PointPair> pairs;
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(20, 10), Eigen::Vector2d(-40, 20)}) {
    pairs.push_back({T * p, p});
  }
  const Similarity2 fit = FitPlanarSimilarity(pairs);
  EXPECT_NEAR(fit.scale, 0.05, 1e-15);
  EXPECT_NEAR(fit.motion.x, 3, 1e-14);
  EXPECT_NEAR(fit.motion.y, -4, 1e-14);
  EXPECT_NEAR(fit.motion.yaw, 2.9, 1e-14);
}

TEST(FitPlanarSimilarity, TakesErrorsForScaleOnlyAsFarAsTheyAre) {
  // A square of 2 m, one corner of which the estimate has 0.4 m further out along x: the mean moves
  // by 0.1, the sums about the means are dot = 8.4, cross = 0.4 (of estimate x truth), and
  // |estimate|^2 = 8.8 + 0.16 - 4 * 0.01.
  const std::vector<PointPair> pairs = {
      {{1, 1}, {1.4, 1}}, {{-1, 1}, {-1, 1}}, {{-1, -1}, {-1, -1}}, {{1, -1}, {1, -1}}};
  const Similarity2 fit = FitPlanarSimilarity(pairs);
  EXPECT_NEAR(fit.scale, std::hypot(8.4, 0.4) / 8.92, 1e-14);
  EXPECT_NEAR(fit.motion.yaw, std::atan2(0.4, 8.4), 1e-14);
}

TEST(FitPlanarSimilarity, ARobotAtRestHasNoScale) {
  EXPECT_EQ(FitPlanarSimilarity({{{1, 2}, {5, 5}}, {{3, 2}, {5, 5}}}).scale, 1);
  EXPECT_EQ(FitPlanarSimilarity({{{1, 2}, {5, 5}}, {{1, 2}, {7, 5}}}).scale, 1);
}

TEST(Similarity2, MovesPosesInSpace) {
  const Similarity2 T{{1, 0, std::numbers::pi / 2}, 2};
  const StampedPose moved = T * ToStampedPose(7, {3, 0, 0.25}, {.pitch_rad = 0.1, .lift_m = 0.05});
  EXPECT_EQ(moved.stamp_s, 7);
  EXPECT_NEAR((moved.position - Eigen::Vector3d(1, 6, 0.1)).norm(), 0, 1e-15);
  EXPECT_NEAR(YawOf(moved), std::numbers::pi / 2 + 0.25, 1e-15);
  EXPECT_NEAR(PitchOf(moved), 0.1, 1e-15);
}

}  // namespace
}  // namespace ceilmap::evaluation
