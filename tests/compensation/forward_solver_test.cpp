#include "compensation/forward_solver.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "calib/base/error.hpp"
#include "calib/base/tilt.hpp"

namespace ceilmap::compensation {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kAxleBehindMast = 0.14;
constexpr double kForward = 0.45;
constexpr double kCeiling = 2.6;

calib::Rig PapersRig() {
  calib::Rig rig;
  rig.axle_behind_mast_m = kAxleBehindMast;
  rig.forward_height_m = kForward;
  rig.ceiling_height_m = kCeiling;
  rig.forward.emplace();
  rig.forward->T_base_cam.translation().z() = kForward;
  return rig;
}

/// A tilted frame and a level keyframe, seen without error: a robot turned in space, and the rays
/// of its cameras on the mast, of which the forward one is perpendicular to a wall.
struct TiltedView {
  double pitch_rad = 0;
  double roll_rad = 0;
  double yaw_rad = 0;                 // of the forward camera
  double pivot_m = -kAxleBehindMast;  // what stays on the floor
  double wall_m = 4;                  // from the frame's camera
  double base_shift_m = 0.3;

  ForwardMotion seen;
  double ceiling_motion_m = 0;

  void Observe() {
    const Tilt tilt{pitch_rad, roll_rad, pivot_m * std::sin(pitch_rad), {}};
    const Isometry3d T = tilt.T_level_base();
    const Vector3d along(std::cos(yaw_rad), std::sin(yaw_rad), 0);
    const Vector3d camera = T * Vector3d(0, 0, kForward);
    Vector3d keyframe = camera + base_shift_m * along;
    keyframe.z() = kForward;
    const Vector3d axis = T.linear() * along;
    const Vector3d from_keyframe = camera + wall_m / axis.dot(along) * axis - keyframe;
    seen.tan_shift = -from_keyframe.z() / from_keyframe.dot(along);
    // Registration finds a wall by cos(th1) narrower and by its square lower.
    const double keystone = std::pow(1 + seen.tan_shift * seen.tan_shift, 0.75);
    seen.zoom = wall_m / (wall_m - base_shift_m) * keystone;
    const Eigen::AngleAxisd turn(yaw_rad, Vector3d::UnitZ());
    const Eigen::Matrix3d of_camera = turn.inverse() * T.linear() * turn;
    seen.roll_rad = std::atan2(of_camera(2, 1), of_camera(2, 2));
    seen.sigma_tan_shift = 1e-3;
    seen.sigma_zoom = 2e-3;
    seen.sigma_roll_rad = 5e-4;
    const Vector3d up = T.linear() * Vector3d::UnitZ();
    const Vector3d met = camera + (kCeiling - camera.z()) / up.z() * up;
    ceiling_motion_m = along.dot(keyframe - met);
  }
  /// The keyframe's data of the wall.
  [[nodiscard]] ForwardSolverParams Known() const {
    ForwardSolverParams params;
    params.wall_per_m = 1 / (wall_m - base_shift_m);
    params.wall_per_m_sigma = 0.01;
    return params;
  }
};

TEST(ForwardSolver, FrontWheelsThatClimbAreExact) {
  for (const double deg : {-6.0, -4.64, -2.0, -0.3}) {
    for (const double base_shift_m : {-0.2, 0.0, 0.1, 0.5}) {
      TiltedView scene;
      scene.pitch_rad = deg * kRadPerDeg;
      scene.base_shift_m = base_shift_m;
      scene.Observe();
      ForwardSolver solver(PapersRig(), 0, scene.Known());
      const auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
      ASSERT_TRUE(tilt.has_value());
      EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 1e-3 * kRadPerDeg)
          << deg << ' ' << base_shift_m;
      EXPECT_NEAR(tilt->angles[1], 0, 1e-12);
    }
  }
}

TEST(ForwardSolver, RearWheelsThatClimbAreExactButForThePivotsPlace) {
  for (const double deg : {0.3, 2.0, 4.64, 6.0}) {
    TiltedView scene;
    scene.pitch_rad = deg * kRadPerDeg;
    scene.pivot_m = 0;
    scene.Observe();
    ForwardSolver solver(PapersRig(), 0, scene.Known());
    auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
    ASSERT_TRUE(tilt.has_value());
    EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 1e-3 * kRadPerDeg) << deg;
    // Front wheels 10 cm before the mast lift its foot by that times the tilt, seen over 4 m.
    scene.pivot_m = 0.1;
    scene.Observe();
    tilt = ForwardSolver(PapersRig(), 0, scene.Known()).Solve(scene.seen, scene.ceiling_motion_m);
    ASSERT_TRUE(tilt.has_value());
    EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 0.027 * scene.pitch_rad) << deg;
  }
}

TEST(ForwardSolver, RollIsTheCamerasWhenItPointsStraightAhead) {
  TiltedView scene;
  scene.pitch_rad = -3 * kRadPerDeg;
  scene.roll_rad = 2.5 * kRadPerDeg;
  scene.Observe();
  ForwardSolver solver(PapersRig(), 0, scene.Known());
  const auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
  ASSERT_TRUE(tilt.has_value());
  EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 0.01 * kRadPerDeg);
  EXPECT_NEAR(tilt->angles[1], scene.roll_rad, 1e-9);
}

// Small turns about level axes: what is neglected is of second order, 3 deg * 3 deg = 0.16 deg.
TEST(ForwardSolver, ACameraThatPointsAsideMixesPitchAndRoll) {
  for (const double yaw_deg : {-30.0, 10.0, 30.0}) {
    for (const Vector2d& deg : {Vector2d(-3, 0), Vector2d(0, 2), Vector2d(-2, -2)}) {
      TiltedView scene;
      scene.pitch_rad = deg[0] * kRadPerDeg;
      scene.roll_rad = deg[1] * kRadPerDeg;
      scene.yaw_rad = yaw_deg * kRadPerDeg;
      scene.pivot_m = 0;  // in any climb: the foot stays
      scene.Observe();
      calib::Rig rig = PapersRig();
      rig.axle_behind_mast_m = 0;
      ForwardSolver solver(rig, scene.yaw_rad, scene.Known());
      const auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
      ASSERT_TRUE(tilt.has_value());
      EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 0.06 * kRadPerDeg) << yaw_deg << ' ' << deg;
      EXPECT_NEAR(tilt->angles[1], scene.roll_rad, 0.06 * kRadPerDeg) << yaw_deg << ' ' << deg;
    }
  }
}

TEST(ForwardSolver, LearnsTheWallsDistanceFromTheZoom) {
  ForwardSolver solver(PapersRig(), 0);  // expects 5 m
  TiltedView scene;
  for (int i = 1; i <= 12; ++i) {
    scene.base_shift_m = 0.4 - 0.02 * i;
    scene.wall_m = 1.6 + scene.base_shift_m;
    scene.Observe();
    const auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
    ASSERT_TRUE(tilt.has_value());
    EXPECT_NEAR(tilt->angles[0], 0, 1e-6);
  }
  scene.pitch_rad = -4.64 * kRadPerDeg;
  scene.Observe();
  const auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
  ASSERT_TRUE(tilt.has_value());
  EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 0.01 * kRadPerDeg);
  const auto guessed = ForwardSolver(PapersRig(), 0).Solve(scene.seen, scene.ceiling_motion_m);
  ASSERT_TRUE(guessed.has_value());
  EXPECT_GT(std::abs(guessed->angles[0] - scene.pitch_rad), 0.1 * kRadPerDeg);
}

// By 1.5 % at 8 degrees, which would put a wall that is 1.6 m away at 1.5 m.
TEST(ForwardSolver, KeystoneIsNoZoom) {
  ForwardSolver solver(PapersRig(), 0);
  TiltedView scene;
  scene.pitch_rad = -8 * kRadPerDeg;
  for (int i = 0; i < 20; ++i) {
    scene.base_shift_m = 0.4;
    scene.wall_m = 1.6 + scene.base_shift_m;
    scene.Observe();
    const auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
    ASSERT_TRUE(tilt.has_value());
    if (i > 15) {
      EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 0.03 * kRadPerDeg) << i;
    }
  }
}

TEST(ForwardSolver, AKeyframeFartherAheadIsNearerToTheWall) {
  TiltedView scene;
  scene.pitch_rad = -4 * kRadPerDeg;
  scene.wall_m = 2;
  scene.Observe();
  ForwardSolverParams params = scene.Known();
  params.wall_per_m = 1 / (scene.wall_m - scene.base_shift_m + 0.7);  // of the keyframe before
  ForwardSolver solver(PapersRig(), 0, params);
  solver.MoveKeyframe(0.7);
  const auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
  ASSERT_TRUE(tilt.has_value());
  EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 2e-3 * kRadPerDeg);
}

// The distance that a frame teaches is not the one that its own tilt was solved with.
TEST(ForwardSolver, OneFrameIsNotMoreAccurateThanItsWall) {
  TiltedView scene;
  scene.pitch_rad = -4.64 * kRadPerDeg;
  scene.wall_m = 1.9;
  scene.Observe();
  scene.seen.sigma_tan_shift = 1e-5;
  scene.seen.sigma_zoom = 1e-4;
  ForwardSolverParams params;
  params.ceiling_motion_sigma_m = 1e-5;
  ForwardSolver solver(PapersRig(), 0, params);
  const auto tilt = solver.Solve(scene.seen, scene.ceiling_motion_m);
  ASSERT_TRUE(tilt.has_value());
  EXPECT_GT(std::abs(tilt->angles[0] - scene.pitch_rad), 0.1 * kRadPerDeg);
  EXPECT_LT(std::abs(tilt->angles[0] - scene.pitch_rad), 4 * std::sqrt(tilt->covariance(0, 0)));
}

TEST(ForwardSolver, WithoutTheCeilingsMotionParallaxIsLeftOut) {
  TiltedView scene;
  scene.pitch_rad = -4 * kRadPerDeg;
  scene.roll_rad = 1 * kRadPerDeg;
  scene.Observe();
  ForwardSolver solver(PapersRig(), 0);
  const auto tilt = solver.Solve(scene.seen, std::nullopt);
  ASSERT_TRUE(tilt.has_value());
  EXPECT_NEAR(tilt->angles[0], std::atan(scene.seen.tan_shift), 1e-15);
  EXPECT_NEAR(tilt->angles[1], scene.roll_rad, 1e-9);
  const double sigma = std::hypot(1e-3, 0.1 * tilt->angles[0]);
  EXPECT_NEAR(std::sqrt(tilt->covariance(0, 0)), sigma, 1e-12);
  EXPECT_LT(std::abs(tilt->angles[0] - scene.pitch_rad), 2 * sigma);
}

TEST(ForwardSolver, CovarianceIsThatOfManyNoisyFrames) {
  TiltedView scene;
  scene.pitch_rad = -4 * kRadPerDeg;
  scene.roll_rad = 1 * kRadPerDeg;
  scene.yaw_rad = 25 * kRadPerDeg;
  scene.wall_m = 2;
  scene.Observe();
  scene.seen.sigma_zoom = 100;  // no information on the wall
  ForwardSolverParams params = scene.Known();
  params.wall_per_m_sigma = 0.05;
  const auto claimed =
      ForwardSolver(PapersRig(), scene.yaw_rad, params).Solve(scene.seen, scene.ceiling_motion_m);
  ASSERT_TRUE(claimed.has_value());

  std::mt19937 random(8);
  std::normal_distribution<double> normal;
  constexpr int kRuns = 20000;
  Vector2d mean = Vector2d::Zero();
  Matrix2d square = Matrix2d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    ForwardMotion seen = scene.seen;
    seen.tan_shift += seen.sigma_tan_shift * normal(random);
    seen.roll_rad += seen.sigma_roll_rad * normal(random);
    ForwardSolverParams other = params;
    other.wall_per_m += params.wall_per_m_sigma * normal(random);
    const double motion_m = scene.ceiling_motion_m + params.ceiling_motion_sigma_m * normal(random);
    const auto tilt = ForwardSolver(PapersRig(), scene.yaw_rad, other).Solve(seen, motion_m);
    ASSERT_TRUE(tilt.has_value());
    const Vector2d off = tilt->angles - claimed->angles;
    mean += off / kRuns;
    square += off * off.transpose() / kRuns;
  }
  const Matrix2d sampled = square - mean * mean.transpose();
  EXPECT_LT((sampled - claimed->covariance).norm(), 0.05 * claimed->covariance.norm())
      << sampled << "\n\n"
      << claimed->covariance;
}

TEST(ForwardSolver, RefusesWhatNoTiltExplains) {
  TiltedView scene;
  scene.Observe();
  scene.seen.tan_shift = 3;
  ForwardSolver solver(PapersRig(), 0);
  EXPECT_FALSE(solver.Solve(scene.seen, scene.ceiling_motion_m).has_value());
  scene.seen.tan_shift = std::nan("");
  EXPECT_FALSE(solver.Solve(scene.seen, scene.ceiling_motion_m).has_value());
}

TEST(ForwardSolver, TakesTheCamerasHeightWhereTheRigHasNoD) {
  TiltedView scene;
  scene.pitch_rad = -4 * kRadPerDeg;
  scene.Observe();
  calib::Rig rig = PapersRig();
  rig.forward_height_m.reset();
  const auto tilt = ForwardSolver(rig, 0, scene.Known()).Solve(scene.seen, scene.ceiling_motion_m);
  ASSERT_TRUE(tilt.has_value());
  EXPECT_NEAR(tilt->angles[0], scene.pitch_rad, 1e-3 * kRadPerDeg);
}

TEST(ForwardSolver, RefusesARigWithoutForwardCamera) {
  calib::Rig rig = PapersRig();
  rig.forward.reset();
  EXPECT_THAT(
      [&] { ForwardSolver(rig, 0); },
      testing::ThrowsMessage<InputError>("the rig has no camera 'forward'; add it under cameras"));
}

}  // namespace
}  // namespace ceilmap::compensation
