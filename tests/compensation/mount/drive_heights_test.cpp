#include "compensation/mount/drive_heights.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace ceilmap::mount {
namespace {

using calibration::PointHeight;

constexpr std::size_t kViews = 40;

/// Points of all views: at a surface, and a number of others between two heights.
struct Seen {
  int of_surface = 10;
  double surface = 1.02;
  int others = 10;
  double from = 1.1;
  double to = 1.5;
};

std::vector<PointHeight> Heights(const Seen& seen) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.004);
  std::uniform_real_distribution<double> other(seen.from, seen.to);
  std::vector<PointHeight> heights;
  for (int view = 0; view < static_cast<int>(kViews); ++view) {
    for (int i = 0; i < seen.of_surface; ++i) {
      heights.push_back({view, i, seen.surface + noise(random), 0.004});
    }
    for (int i = 0; i < seen.others; ++i) {
      heights.push_back({view, seen.of_surface + i, other(random), 0.004});
    }
  }
  return heights;
}

TEST(ReferencePlane, IsTheFarthestSurface) {
  const auto plane = ReferencePlane(Heights({}), kViews);
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->value, 1.02, 0.002);
  EXPECT_LT(plane->sigma, 0.005);
}

TEST(ReferencePlane, IsNothingBelowMuchElse) {
  EXPECT_TRUE(ReferencePlane(Heights({.others = 2, .from = 0.8, .to = 0.95}), kViews));
  EXPECT_FALSE(ReferencePlane(
      Heights({.of_surface = 20, .surface = 1.2, .others = 20, .from = 0.5, .to = 1.1}), kViews));
  EXPECT_FALSE(ReferencePlane({}, kViews));
}

TEST(ReferencePlane, HasADeviationWherePartsOfTheDriveDisagree) {
  std::vector<PointHeight> heights = Heights({});
  for (PointHeight& point : heights) {
    if (point.view >= 30) point.rho *= 1.03;
  }
  const auto plane = ReferencePlane(heights, kViews);
  ASSERT_TRUE(plane);
  EXPECT_GT(plane->sigma, 0.006);
}

TEST(TakeAsPlane, ScalesPosesAndHeightsAgainstEachOther) {
  calibration::DriveSolution solution;
  solution.cameras = {{0, 0, 0}, {1, -2, 0.5}};
  solution.heights = {{0, 4, 1.2, 0.1}};
  TakeAsPlane(0.8, solution);
  EXPECT_DOUBLE_EQ(solution.cameras[1].x, 0.8);
  EXPECT_DOUBLE_EQ(solution.cameras[1].y, -1.6);
  EXPECT_DOUBLE_EQ(solution.cameras[1].yaw, 0.5);
  EXPECT_DOUBLE_EQ(solution.heights[0].rho, 1.5);
  EXPECT_DOUBLE_EQ(solution.heights[0].sigma, 0.125);
}

}  // namespace
}  // namespace ceilmap::mount
