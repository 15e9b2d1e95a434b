#include "calib/solve/rig_solver.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace ceilmap::calibration {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kRigFocalPx = 400;

RigMount TrueMount() {
  RigMount mount;
  mount.tilt_rad = Vector2d(1.2, -0.7) * kRadPerDeg;
  mount.centre = {0.05, 0.07};
  mount.yaw_rad = 94 * kRadPerDeg;
  return mount;
}

/// Observes points of the ceiling, in the mounted camera's frame, with noise. Points of a rolling
/// shutter are seen from where the camera is at the time of their row.
class MovingCamera {
 public:
  MovingCamera(const RigMount& mount, unsigned seed, double noise_px)
      : mount_(mount), random_(seed), noise_(noise_px / kRigFocalPx) {
    const Vector3d turn(mount.tilt_rad.x(), mount.tilt_rad.y(), 0);
    R_cam_twin_ = Eigen::AngleAxisd(-turn.norm(), turn.normalized()).toRotationMatrix();
  }

  /// @param views  axle and heading. @param shifted  a point that moves as nothing on the ceiling.
  /// @param velocities  of the axle, in the axes of the levelled camera; empty: at rest.
  Recording Record(const std::vector<Pose2>& views,
                   int outliers = 0,
                   const std::vector<ViewVelocity>& velocities = {}) {
    Recording recording;
    for (const ViewVelocity& axle : velocities) {
      const Vector2d turning(-mount_.centre.y(), mount_.centre.x());
      recording.velocities.push_back({axle.linear + axle.yaw_rad_s * turning, axle.yaw_rad_s});
    }
    axle_velocities_ = velocities;
    for (const Pose2& view : views) recording.cameras.push_back(CameraPose(views.front(), view));
    const int n = static_cast<int>(views.size());
    for (int first = 0; first < n; ++first) {
      for (const int apart : {1, 2, 5, 9, 14}) {
        if (first + apart >= n) break;
        ViewPair pair{first, first + apart, {}};
        for (int k = 0; k < 20; ++k) {
          pair.places.push_back(Place(views, first, first + apart, k < outliers));
        }
        recording.pairs.push_back(pair);
      }
    }
    return recording;
  }

 private:
  [[nodiscard]] Pose2 CameraPose(const Pose2& first, const Pose2& view) const {
    const auto pose = [&](const Pose2& v) {
      const Vector2d at = v * mount_.centre;
      return Pose2{at.x(), at.y(), v.yaw};
    };
    return pose(first).Inverse() * pose(view);
  }

  PointCorrespondence Place(const std::vector<Pose2>& views, int first, int second, bool outlier) {
    std::uniform_real_distribution<double> anywhere(-0.5, 0.5);
    const Vector2d seen(anywhere(random_), anywhere(random_));
    PointCorrespondence place;
    place.first_row = seen.y();
    const Vector2d point = PoseAtRow(views, first, place.first_row) * (mount_.centre + seen);
    Vector2d again = Vector2d::Zero();
    for (int i = 0; i < 5; ++i) {  // the row depends on where it is seen
      place.second_row = again.y();
      again = PoseAtRow(views, second, place.second_row).Inverse() * point - mount_.centre;
    }
    place.first = Ray(seen);
    place.second = Ray(again);
    if (outlier) place.second += Vector2d(0.02, 0.01);
    return place;
  }

  /// The axle at the time of a row.
  [[nodiscard]] Pose2 PoseAtRow(const std::vector<Pose2>& views, int view, double row) const {
    const auto i = static_cast<std::size_t>(view);
    if (axle_velocities_.empty()) return views[i];
    const ViewVelocity& v = axle_velocities_[i];
    const double time_s = row * mount_.readout_time_s;
    const Vector2d moved = Pose2{0, 0, 0.5 * time_s * v.yaw_rad_s} * Vector2d(time_s * v.linear);
    return views[i] * Pose2{moved.x(), moved.y(), time_s * v.yaw_rad_s};
  }

  Vector2d Ray(const Vector2d& seen) {
    const Vector2d ray = (R_cam_twin_ * seen.homogeneous()).hnormalized();
    return ray + noise_ * Vector2d(normal_(random_), normal_(random_));
  }

  RigMount mount_;
  std::vector<ViewVelocity> axle_velocities_;
  std::mt19937 random_;
  double noise_;
  std::normal_distribution<double> normal_;
  Eigen::Matrix3d R_cam_twin_;
};

std::vector<Pose2> Spin(int views) {
  std::vector<Pose2> poses;
  for (int i = 0; i < views; ++i) {
    poses.push_back({0, 0, WrapAngle(2 * std::numbers::pi * i / (views - 1))});
  }
  return poses;
}

/// Ahead of base is (cos yaw, -sin yaw) in the first view.
std::vector<Pose2> Ahead(const RigMount& mount, int views, double length) {
  std::vector<Pose2> poses;
  for (int i = 0; i < views; ++i) {
    const double s = length * i / (views - 1);
    poses.push_back({s * std::cos(mount.yaw_rad), -s * std::sin(mount.yaw_rad), 0});
  }
  return poses;
}

struct Case {
  Recording spin;
  Recording straight;
};

Case MakeCase(unsigned seed, double noise_px, int outliers = 0) {
  MovingCamera camera(TrueMount(), seed, noise_px);
  return {camera.Record(Spin(31), outliers), camera.Record(Ahead(TrueMount(), 21, 1.5), outliers)};
}

RigSolution Solve(const Case& c, double lens_sigma_px = 0) {
  RigSolverParams params;
  params.focal_px = kRigFocalPx;
  params.lens_sigma_px = lens_sigma_px;
  return SolveRig(c.spin, c.straight, GuessMount(c.spin, c.straight), params);
}

using MountErrors = Eigen::Matrix<double, 6, 1>;  // in the order of RigUnknown

MountErrors ErrorsOf(const RigSolution& solution) {
  const RigMount truth = TrueMount();
  MountErrors errors;
  errors << solution.mount.tilt_rad - truth.tilt_rad, solution.mount.centre - truth.centre,
      WrapAngle(solution.mount.yaw_rad - truth.yaw_rad), solution.travel - 1.5;
  return errors;
}

TEST(RigSolver, FindsTheMountOfExactPlaces) {
  const RigSolution solution = Solve(MakeCase(1, 0));
  ASSERT_TRUE(solution.ok);
  EXPECT_LT(ErrorsOf(solution).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_EQ(solution.inliers, solution.places);
}

TEST(RigSolver, TheCentreIsGivenInBaseAxes) {
  // Turned by 90 degrees, what is above the image's centre (smaller v) is ahead.
  RigMount mount;
  mount.yaw_rad = 90 * kRadPerDeg;
  mount.centre = {0.02, -0.05};
  EXPECT_NEAR(mount.CentreInBase().x(), 0.05, 1e-12);
  EXPECT_NEAR(mount.CentreInBase().y(), 0.02, 1e-12);
}

TEST(RigSolver, TheGuessIsNearForALevelCamera) {
  const Case c = MakeCase(1, 0);
  const RigMount guess = GuessMount(c.spin, c.straight);
  EXPECT_LT((guess.centre - TrueMount().centre).norm(), 1e-9);
  EXPECT_NEAR(guess.yaw_rad, TrueMount().yaw_rad, 1e-9);
}

TEST(RigSolver, WhatMovesAsNoCeilingDoesIsLeftOut) {
  const RigSolution solution = Solve(MakeCase(2, 0.05, 4));
  ASSERT_TRUE(solution.ok);
  const auto errors = ErrorsOf(solution);
  EXPECT_LT(errors.head<2>().norm(), 0.003 * kRadPerDeg);
  EXPECT_LT(errors.segment<2>(2).norm(), 1e-4);
  EXPECT_LT(std::abs(errors[4]), 0.02 * kRadPerDeg);
  EXPECT_NEAR(solution.inliers, 0.8 * solution.places, 0.02 * solution.places);
}

TEST(RigSolver, ErrorsAreAsLargeAsTheirDeviations) {
  constexpr int kCases = 12;
  MountErrors squares = MountErrors::Zero();
  for (unsigned seed = 0; seed < kCases; ++seed) {
    const RigSolution solution = Solve(MakeCase(10 + seed, 0.1));
    ASSERT_TRUE(solution.ok);
    const auto variances = solution.covariance.diagonal().head<6>();
    squares += ErrorsOf(solution).cwiseAbs2().cwiseQuotient(variances);
    EXPECT_NEAR(solution.sigma_px, 0.1 * std::sqrt(2.0), 0.02);
  }
  for (int i = 0; i < 6; ++i) {
    EXPECT_GT(std::sqrt(squares[i] / kCases), 0.5) << i;
    EXPECT_LT(std::sqrt(squares[i] / kCases), 1.7) << i;
  }
}

TEST(RigSolver, AWrongLensIsInsideItsDeviation) {
  Case c = MakeCase(3, 0.02);
  for (Recording* recording : {&c.spin, &c.straight}) {
    for (ViewPair& pair : recording->pairs) {
      for (PointCorrespondence& place : pair.places) {
        place.first.x() += 0.5 / kRigFocalPx;  // the principal point is half a pixel off
        place.second.x() += 0.5 / kRigFocalPx;
      }
    }
  }
  const RigSolution blind = Solve(c);
  const RigSolution solution = Solve(c, 0.5);
  // The centre takes it over, and residuals do not show it.
  const double error = std::abs(ErrorsOf(solution)[2]);
  EXPECT_NEAR(error, 0.5 / kRigFocalPx, 0.1 / kRigFocalPx);
  EXPECT_GT(error, 10 * std::sqrt(blind.covariance(2, 2)));
  EXPECT_LT(error, 2 * std::sqrt(solution.covariance(2, 2)));
}

/// A turn on the spot that becomes faster, and a drive.
Case RollingCase(unsigned seed, double noise_px, double readout_time_s) {
  RigMount mount = TrueMount();
  mount.readout_time_s = readout_time_s;
  MovingCamera camera(mount, seed, noise_px);
  const std::vector<Pose2> spin = Spin(31);
  std::vector<ViewVelocity> turning;
  for (int i = 0; i < 31; ++i) turning.push_back({{0, 0}, 0.4 + 0.01 * i});
  const ViewVelocity ahead{0.2 * Vector2d(std::cos(mount.yaw_rad), -std::sin(mount.yaw_rad)), 0};
  const std::vector<Pose2> straight = Ahead(mount, 21, 1.5);
  return {camera.Record(spin, 0, turning),
          camera.Record(straight, 0, std::vector<ViewVelocity>(straight.size(), ahead))};
}

RigSolution SolveRolling(const Case& c, bool readout_is_free, double start_s = 0) {
  RigSolverParams params;
  params.focal_px = kRigFocalPx;
  params.lens_sigma_px = 0;
  RigMount start = GuessMount(c.spin, c.straight);
  start.readout_time_s = start_s;
  return SolveRig(c.spin, c.straight, start, params, readout_is_free);
}

TEST(RigSolver, FindsTheReadoutTime) {
  for (const double readout_time_s : {0.033, -0.02, 0.0}) {
    const RigSolution solution = SolveRolling(RollingCase(1, 0, readout_time_s), true);
    ASSERT_TRUE(solution.ok);
    EXPECT_NEAR(solution.mount.readout_time_s, readout_time_s, 1e-8);
    EXPECT_LT(ErrorsOf(solution).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(RigSolver, TheReadoutTimeIsAsAccurateAsItsDeviation) {
  constexpr int kCases = 12;
  double squares = 0;
  for (unsigned seed = 0; seed < kCases; ++seed) {
    const RigSolution solution = SolveRolling(RollingCase(40 + seed, 0.1, 0.025), true);
    ASSERT_TRUE(solution.ok);
    const double variance = solution.covariance(kReadout, kReadout);
    EXPECT_LT(std::sqrt(variance), 1e-3);
    const double error = solution.mount.readout_time_s - 0.025;
    squares += error * error / variance;
  }
  EXPECT_GT(std::sqrt(squares / kCases), 0.5);
  EXPECT_LT(std::sqrt(squares / kCases), 1.7);
}

TEST(RigSolver, AKnownReadoutTimeIsKept) {
  const Case c = RollingCase(2, 0, 0.033);
  const RigSolution known = SolveRolling(c, false, 0.033);
  ASSERT_TRUE(known.ok);
  EXPECT_EQ(known.mount.readout_time_s, 0.033);
  EXPECT_EQ(known.covariance(kReadout, kReadout), 0);
  EXPECT_LT(ErrorsOf(known).cwiseAbs().maxCoeff(), 1e-7);
  const RigSolution ignored = SolveRolling(c, false, 0);
  EXPECT_GT(ErrorsOf(ignored).head<2>().norm(), 0.1 * kRadPerDeg);
}

TEST(RigSolver, NothingToSolve) {
  EXPECT_FALSE(Solve({}).ok);
  Case c = MakeCase(1, 0);
  c.spin.pairs.clear();
  c.straight.pairs.clear();
  EXPECT_FALSE(Solve(c).ok);
}

}  // namespace
}  // namespace ceilmap::calibration
