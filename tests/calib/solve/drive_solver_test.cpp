// Errors of a camera from exact points of a drive under a ceiling.

#include "calib/solve/drive_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "calib/base/degrees.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Straight up, the top of the image to the front.
calib::MountedCamera Fisheye() {
  calib::MountedCamera up;
  up.camera = calib::Lens::WithoutDistortion(calib::LensModel::kEquidistant, {640, 480}, 300);
  up.T_base_cam.linear() = Eigen::AngleAxisd(90 * kRadPerDeg, Vector3d::UnitZ()).toRotationMatrix();
  return up;
}

struct CameraTruth {
  Vector2d tilt_rad{0, 0};
  double focal_ratio = 1;
  double readout_s = 0;
  double depth = 0;  ///< most of the points' distance from the plane, of Z
};

/// A drive with straight parts and turns, and what a camera with errors sees of it.
class DriveWorld {
 public:
  explicit DriveWorld(const CameraTruth& truth) : truth_(truth), up_(Fisheye()), lens_(up_.camera) {
    lens_.fx *= truth.focal_ratio;
    lens_.fy *= truth.focal_ratio;
    const Vector3d turn(truth.tilt_rad.x(), truth.tilt_rad.y(), 0);
    if (turn.norm() > 0) {
      R_level_cam_ = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    }
    Pose2 at;
    for (int i = 0; i < 40; ++i) {
      const bool turns = i % 12 > 7;
      const ViewVelocity velocity{turns ? Vector2d(0.02, 0.05) : Vector2d(0.05, 0.3),
                                  turns ? 0.9 : 0.0};
      drive_.cameras.push_back(at);
      drive_.velocities.push_back(velocity);
      constexpr double kStepS = 0.3;
      at = at * Pose2{velocity.linear.x() * kStepS,
                      velocity.linear.y() * kStepS,
                      velocity.yaw_rad_s * kStepS};
    }
    drive_.starts = {0};
    for (int first = 0; first < 40; ++first) {
      for (const int apart : {1, 2, 4, 8}) {
        if (first + apart < 40) AddPair(first, first + apart);
      }
    }
  }

  [[nodiscard]] DriveSolution Solve(const DriveUnknowns& params) const {
    return SolveDrive(up_, drive_, params);
  }

 private:
  struct Sight {
    Vector2d ray;  // as the rig interprets the pixel
    double row = 0;
  };

  Sight See(const Vector3d& point, int view) {
    const auto i = static_cast<std::size_t>(view);
    Sight sight;
    for (int round = 0; round < 4; ++round) {  // the row depends on the time
      const double time = truth_.readout_s * sight.row;
      const ViewVelocity& v = drive_.velocities[i];
      const Pose2 at =
          drive_.cameras[i] * Pose2{v.linear.x() * time, v.linear.y() * time, v.yaw_rad_s * time};
      const Vector2d seen = at.Inverse() * Vector2d(point.head<2>());
      const Vector3d p_cam = R_level_cam_.transpose() * Vector3d(seen.x(), seen.y(), point.z());
      const Vector2d pixel = *lens_.Project(p_cam);
      sight.row = pixel.y() / (lens_.height_px - 1) - 0.5;
      sight.ray = up_.camera.Ray(pixel)->hnormalized();
    }
    return sight;
  }

  void AddPair(int first, int second) {
    std::uniform_real_distribution<double> anywhere(-0.8, 0.8);
    std::uniform_real_distribution<double> height(1 - truth_.depth, 1);
    ViewPair pair{first, second, {}};
    for (int k = 0; k < 30; ++k) {
      const Vector2d place = drive_.cameras[static_cast<std::size_t>(first)] *
                             Vector2d(anywhere(random_), anywhere(random_));
      const Vector3d point(place.x(), place.y(), height(random_));
      const Sight a = See(point, first);
      const Sight b = See(point, second);
      pair.places.push_back({a.ray, b.ray, a.row, b.row, Eigen::Matrix2d::Identity()});
    }
    drive_.pairs.push_back(pair);
  }

  CameraTruth truth_;
  calib::MountedCamera up_;
  calib::Lens lens_;
  Matrix3d R_level_cam_ = Matrix3d::Identity();
  Drive drive_;
  std::mt19937 random_{7};
};

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

TEST(DriveSolver, NeedsViews) {
  Drive drive;
  drive.cameras.resize(2);
  drive.velocities.resize(2);
  drive.starts = {0};
  EXPECT_FALSE(SolveDrive(Fisheye(), drive, {}).ok);
}

}  // namespace
}  // namespace ceilmap::calibration
