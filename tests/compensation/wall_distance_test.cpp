#include "compensation/wall_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ceilmap::compensation {
namespace {

constexpr double kPrior = 0.2;
constexpr double kPriorSigma = 0.15;
constexpr double kWall_m = 2.5;  // from the keyframe

WallDistance Unlearned() {
  return {kPrior, kPriorSigma};
}

/// How much larger the keyframe shows the wall than a frame so far behind it.
double Zoom(double base_shift_m, double wall_m = kWall_m) {
  return (wall_m + base_shift_m) / wall_m;
}

/// Shown exact zooms over half a metre before the keyframe and after it.
WallDistance Learned(double wall_m = kWall_m) {
  WallDistance wall = Unlearned();
  for (int i = -10; i <= 10; ++i) wall.Learn(Zoom(0.05 * i, wall_m), 0.002, 0.05 * i);
  return wall;
}

TEST(WallDistance, BeginsWithWhatIsExpected) {
  const WallDistance wall = Unlearned();
  EXPECT_DOUBLE_EQ(wall.PerMetre(0), kPrior);
  EXPECT_DOUBLE_EQ(wall.PerMetre(1), 1 / 6.0);  // a frame behind: 5 m and 1 m
  EXPECT_DOUBLE_EQ(wall.PerMetre(-1), 1 / 4.0);
  EXPECT_DOUBLE_EQ(wall.Sigma(0), kPriorSigma);
}

TEST(WallDistance, WeighsOneZoomByHand) {
  // Seen 0.25 / m with sigma 0.02 / 0.4 = 0.05: a gain of 0.0225 / 0.025 = 0.9.
  WallDistance wall = Unlearned();
  wall.Learn(1.1, 0.02, 0.4);
  EXPECT_NEAR(wall.PerMetre(0), 0.245, 1e-12);
  EXPECT_NEAR(wall.Sigma(0), std::sqrt(0.00225), 1e-12);
}

TEST(WallDistance, LearnsAWall) {
  for (const double wall_m : {1.5, 2.5, 8.0}) {
    const WallDistance wall = Learned(wall_m);
    EXPECT_NEAR(wall.PerMetre(0), 1 / wall_m, 2e-3) << wall_m;
    EXPECT_NEAR(wall.PerMetre(0.5), 1 / (wall_m + 0.5), 2e-3) << wall_m;
    EXPECT_LT(wall.Sigma(0), 0.01);
  }
}

TEST(WallDistance, LearnsFromNoisyZoomsToItsSigma) {
  std::mt19937 random(6);
  std::normal_distribution<double> noise(0, 0.003);
  double sum2 = 0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    WallDistance wall = Unlearned();
    for (int i = 1; i <= 20; ++i) wall.Learn(Zoom(0.02 * i) + noise(random), 0.003, 0.02 * i);
    sum2 += std::pow((wall.PerMetre(0) - 1 / kWall_m) / wall.Sigma(0), 2);
  }
  // It forgets a little at each frame, so it claims to know less than it does.
  EXPECT_LT(sum2 / kRuns, 1.2);
  EXPECT_GT(sum2 / kRuns, 0.1);
}

TEST(WallDistance, IsNotMovedByOutliers) {
  WallDistance wall = Learned();
  const double before = wall.PerMetre(0);
  for (const double zoom : {2.0, 0.5, 0.9, 1.4}) wall.Learn(zoom, 0.002, 0.4);
  EXPECT_EQ(wall.PerMetre(0), before);
}

TEST(WallDistance, LearnsNothingFromAFrameAtTheKeyframe) {
  WallDistance wall = Unlearned();
  wall.Learn(1.05, 1e-6, 0.019);
  wall.Learn(1.05, 1e-6, -0.019);
  wall.Learn(1.05, 1e-6, 0);
  EXPECT_EQ(wall.PerMetre(0), kPrior);
  EXPECT_EQ(wall.Sigma(0), kPriorSigma);
}

TEST(WallDistance, NoticesThatTheWallChanged) {
  WallDistance wall = Learned(2.5);
  for (int i = 0; i < 60; ++i) wall.Learn(Zoom(0.4, 4), 0.01, 0.4);  // a door opens
  EXPECT_NEAR(wall.PerMetre(0), 0.25, 0.01);
}

TEST(WallDistance, MovesAheadExactly) {
  WallDistance wall = Learned();
  const double distance_m = 1 / wall.PerMetre(0);
  const double sigma = wall.Sigma(0);
  wall.MoveAhead(1);
  EXPECT_NEAR(1 / wall.PerMetre(0), distance_m - 1, 1e-12);
  EXPECT_NEAR(1 / wall.PerMetre(0.4), distance_m - 0.6, 1e-12);
  EXPECT_NEAR(wall.Sigma(0), std::hypot(sigma, 0.1), 1e-12);
  wall.MoveAhead(-2);
  EXPECT_NEAR(1 / wall.PerMetre(0), distance_m + 1, 1e-12);
  // What was learned fades, but never below what was expected.
  wall.MoveAhead(-50);
  EXPECT_EQ(wall.Sigma(0), kPriorSigma);
}

TEST(WallDistance, StaysInFrontOfTheCamera) {
  const WallDistance wall = Learned();
  constexpr double kMax = 1 / 0.3;
  EXPECT_EQ(wall.PerMetre(-2.4), kMax);
  EXPECT_EQ(wall.PerMetre(-2.5), kMax);
  EXPECT_EQ(wall.PerMetre(-100), kMax);
  WallDistance far = Unlearned();
  for (int i = 0; i < 10; ++i) far.Learn(0.99, 0.01, 0.5);  // noise puts it behind infinity
  EXPECT_EQ(far.PerMetre(0), 0);
  EXPECT_EQ(far.PerMetre(3), 0);
}

}  // namespace
}  // namespace ceilmap::compensation
