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

/// Observes points of the ceiling, in the mounted camera's frame, with noise.
class MovingCamera {
 public:
  MovingCamera(const RigMount& mount, unsigned seed, double noise_px)
      : mount_(mount), random_(seed), noise_(noise_px / kRigFocalPx) {
    const Vector3d turn(mount.tilt_rad.x(), mount.tilt_rad.y(), 0);
    R_cam_twin_ = Eigen::AngleAxisd(-turn.norm(), turn.normalized()).toRotationMatrix();
  }

  /// @param views  axle and heading. @param shifted  a point that moves as nothing on the ceiling.
  Recording Record(const std::vector<Pose2>& views, int outliers = 0) {
    Recording recording;
    for (const Pose2& view : views) recording.cameras.push_back(CameraPose(views.front(), view));
    const int n = static_cast<int>(views.size());
    for (int first = 0; first < n; ++first) {
      for (const int apart : {1, 2, 5, 9, 14}) {
        if (first + apart >= n) break;
        ViewPair pair{first, first + apart, {}};
        for (int k = 0; k < 20; ++k) {
          pair.places.push_back(Place(views[static_cast<std::size_t>(first)],
                                      views[static_cast<std::size_t>(first + apart)],
                                      k < outliers));
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

  PointCorrespondence Place(const Pose2& first, const Pose2& second, bool outlier) {
    std::uniform_real_distribution<double> anywhere(-0.5, 0.5);
    const Vector2d seen(anywhere(random_), anywhere(random_));
    const Vector2d point = first * (mount_.centre + seen);
    const Vector2d again = second.Inverse() * point - mount_.centre;
    PointCorrespondence place{Ray(seen), Ray(again), Eigen::Matrix2d::Identity()};
    if (outlier) place.second += Vector2d(0.02, 0.01);
    return place;
  }

  Vector2d Ray(const Vector2d& seen) {
    const Vector2d ray = (R_cam_twin_ * seen.homogeneous()).hnormalized();
    return ray + noise_ * Vector2d(normal_(random_), normal_(random_));
  }

  RigMount mount_;
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

Eigen::Matrix<double, 6, 1> ErrorsOf(const RigSolution& solution) {
  const RigMount truth = TrueMount();
  Eigen::Matrix<double, 6, 1> errors;
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
  Eigen::Matrix<double, 6, 1> squares = Eigen::Matrix<double, 6, 1>::Zero();
  for (unsigned seed = 0; seed < kCases; ++seed) {
    const RigSolution solution = Solve(MakeCase(10 + seed, 0.1));
    ASSERT_TRUE(solution.ok);
    const auto variances = solution.covariance.diagonal();
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

TEST(RigSolver, NothingToSolve) {
  EXPECT_FALSE(Solve({}).ok);
  Case c = MakeCase(1, 0);
  c.spin.pairs.clear();
  c.straight.pairs.clear();
  EXPECT_FALSE(Solve(c).ok);
}

}  // namespace
}  // namespace ceilmap::calibration
