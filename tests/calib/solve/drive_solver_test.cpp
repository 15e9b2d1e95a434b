// Errors of a camera from exact points of a drive under a ceiling.

#include "calib/solve/drive_solver.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calib/base/degrees.hpp"
#include "tests/calib/solve/drive_world.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Vector2d;
using synthetic::CameraTruth;
using synthetic::DriveWorld;
using synthetic::Fisheye;

TEST(DriveSolver, ARightCameraHasNoErrors) {
  const DriveSolution solution = DriveWorld({}).Solve({.focal = true, .radial = true});
  ASSERT_TRUE(solution.ok);
  EXPECT_LT(solution.errors.norm(), 1e-6);
  EXPECT_EQ(solution.depth_ratio, 0);
  EXPECT_EQ(solution.inliers, solution.places);
}

TEST(DriveSolver, FindsTiltAndReadout) {
  CameraTruth truth;
  truth.tilt_rad = Vector2d(2, -1) * kRadPerDeg;
  truth.readout_s = 0.02;
  const DriveSolution solution = DriveWorld(truth).Solve({});
  ASSERT_TRUE(solution.ok);
  EXPECT_NEAR(solution.errors[kCameraTiltX], truth.tilt_rad.x(), 0.01 * kRadPerDeg);
  EXPECT_NEAR(solution.errors[kCameraTiltY], truth.tilt_rad.y(), 0.01 * kRadPerDeg);
  EXPECT_NEAR(solution.errors[kCameraReadout], truth.readout_s, 2e-4);
}

TEST(DriveSolver, AFisheyeShowsItsFocalLength) {
  CameraTruth truth;
  truth.focal_ratio = 1.03;
  const DriveSolution solution = DriveWorld(truth).Solve({.focal = true});
  ASSERT_TRUE(solution.ok);
  EXPECT_NEAR(1 / (1 - solution.errors[kCameraFocal]), 1.03, 0.004);  // to first order
  // Without it, the lens shows a radial error.
  EXPECT_GT(DriveWorld(truth).Solve({.radial = true}).errors.segment<2>(kCameraRadial3).norm(), 1);
}

TEST(DriveSolver, DepthOfTheCeilingIsNoErrorOfTheCamera) {
  CameraTruth truth;
  truth.depth = 0.3;
  const DriveSolution solution = DriveWorld(truth).Solve({.radial = true});
  ASSERT_TRUE(solution.ok);
  EXPECT_GT(solution.depth_ratio, 0.02);
  EXPECT_LT(solution.errors.head<2>().norm(), 0.1 * kRadPerDeg);
  EXPECT_LT(solution.errors.segment<2>(kCameraRadial3).norm(), 0.5);
  EXPECT_NEAR(solution.errors[kCameraReadout], 0, 0.001);
}

TEST(DriveSolver, PointsWithHeightsShowTheCamera) {
  CameraTruth truth;
  truth.tilt_rad = Vector2d(1, -0.5) * kRadPerDeg;
  truth.focal_ratio = 1.03;
  truth.readout_s = 0.02;
  truth.depth = 0.4;
  const DriveWorld world(truth);
  const DriveSolution solution = world.Solve({.focal = true, .heights = true});
  ASSERT_TRUE(solution.ok);
  EXPECT_NEAR(1 / (1 - solution.errors[kCameraFocal]), 1.03, 0.004);
  EXPECT_NEAR(solution.errors[kCameraTiltX], truth.tilt_rad.x(), 0.05 * kRadPerDeg);
  EXPECT_NEAR(solution.errors[kCameraTiltY], truth.tilt_rad.y(), 0.05 * kRadPerDeg);
  EXPECT_NEAR(solution.errors[kCameraReadout], truth.readout_s, 5e-4);
  EXPECT_LT(std::sqrt(solution.covariance(kCameraFocal, kCameraFocal)), 0.003);
  EXPECT_LT(solution.sigma_px, 0.3);
  EXPECT_GT(solution.depth_ratio, 0.1);
  // All heights may have a common factor.
  ASSERT_GT(solution.heights.size(), 1000U);
  double factor = 0;
  for (const PointHeight& point : solution.heights) factor += point.rho / world.RhoOf(point);
  factor /= static_cast<double>(solution.heights.size());
  EXPECT_NEAR(factor, 1, 0.03);
  std::size_t right = 0;
  for (const PointHeight& point : solution.heights) {
    if (std::abs(point.rho / factor / world.RhoOf(point) - 1) < 0.02) ++right;
  }
  EXPECT_GT(right, solution.heights.size() * 9 / 10);
}

TEST(DriveSolver, GivesTheHeightsOfOtherPointsUnderAKnownCamera) {
  CameraTruth truth;
  truth.depth = 0.4;
  const DriveWorld world(truth);
  DriveSolution known = world.Solve({.heights = true});
  ASSERT_TRUE(known.ok);
  const std::vector<PointHeight> heights = HeightsOf(Fisheye(), world.GetDrive(), known);
  ASSERT_EQ(heights.size(), known.heights.size());
  for (std::size_t i = 0; i < heights.size(); ++i) {
    EXPECT_NEAR(heights[i].rho, known.heights[i].rho, 0.02);
    EXPECT_GT(heights[i].sigma, 0);
  }
}

TEST(DriveSolver, NeedsViews) {
  Drive drive;
  drive.cameras.resize(2);
  drive.velocities.resize(2);
  drive.starts = {0};
  EXPECT_FALSE(SolveDrive(Fisheye(), drive, {}).ok);
}

}  // namespace
}  // namespace ceilmap::calibration
