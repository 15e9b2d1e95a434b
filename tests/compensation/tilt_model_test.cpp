#include "compensation/tilt_model.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "calib/base/error.hpp"
#include "tests/compensation/error_of.hpp"

namespace ceilmap::compensation {
namespace {

using synthetic::ErrorOf;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A random robot and a tilt of -12..12 deg. The pivot may lie on either side.
struct TiltedRobot {
  double pivot_m;
  double camera_height_m;
  double ceiling_height_m;
  double tilt_rad;

  explicit TiltedRobot(std::mt19937& random) {
    const auto draw = [&random](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    pivot_m = draw(-0.6, 0.6);
    camera_height_m = draw(0.2, 1.5);
    ceiling_height_m = draw(2, 8);
    tilt_rad = draw(-12, 12) * kRadPerDeg;
  }
  [[nodiscard]] TiltModel Model() const { return {pivot_m, ceiling_height_m}; }
};

/// Where the ray from `start` along `direction` meets the horizontal plane at height z_m.
Eigen::Vector3d MeetPlane(const Eigen::Vector3d& start,
                          const Eigen::Vector3d& direction,
                          double z_m) {
  return start + direction * ((z_m - start.z()) / direction.z());
}

/// The robot of base turned about a pivot on the floor: p_level = T * p_base.
Eigen::Isometry3d TurnAbout(const Eigen::Vector3d& pivot, const Eigen::AngleAxisd& turn) {
  return Eigen::Translation3d(pivot) * turn * Eigen::Translation3d(-pivot);
}

/// Nose down is a positive turn about y: z goes to x.
Eigen::Isometry3d Pitched(const TiltedRobot& robot) {
  return TurnAbout({robot.pivot_m, 0, 0}, {robot.tilt_rad, Eigen::Vector3d::UnitY()});
}

// The robot of the paper's experiment: a = 14 cm, h = 260 cm.
TEST(TiltModel, GivesThePapersNumbers) {
  const TiltModel model(0.14, 2.6);
  EXPECT_NEAR(model.CeilingShift(4.64 * kRadPerDeg), 0.21, 5e-4);
  EXPECT_NEAR(model.CeilingShift(3.76 * kRadPerDeg), 0.17, 5e-4);
  EXPECT_NEAR(model.CeilingShift(1.99 * kRadPerDeg), 0.09, 5e-4);
}

// At 30 deg sin is 1/2 and tan is 1/sqrt(3): the foot stands 0.1 m up, the camera at
// 0.1 + 0.5 cos(30 deg), and the axis climbs the 2 - 0.1 m from the foot to the ceiling.
TEST(TiltModel, IsRightByHand) {
  const TiltModel model(0.2, 2);
  const double tilt = std::numbers::pi / 6;
  const double root3 = std::numbers::sqrt3;
  EXPECT_NEAR(model.CeilingShift(tilt), 1.9 / root3, 1e-15);
  EXPECT_NEAR(model.MastLength(tilt, 0.5), 0.5 + 0.2 / root3, 1e-15);
  EXPECT_NEAR(model.CameraHeight(tilt, 0.5), 0.1 + 0.25 * root3, 1e-15);
  EXPECT_NEAR(model.BaseShift(tilt, 0.5, 1), 1 + (1.9 - 0.25 * root3) / root3, 1e-15);
}

// The rear axle 14 cm behind the mast stays on the floor and the front wheels climb: the nose goes
// up, and the camera's axis points at a point behind the mast.
TEST(TiltModel, PointsBackWhenTheFrontWheelsClimb) {
  const TiltModel model(-0.14, 2.6);
  const double tilt = -4 * kRadPerDeg;
  EXPECT_LT(model.CeilingShift(tilt), -0.17);
  EXPECT_GT(model.MastLength(tilt, 0.45), 0.45);
  EXPECT_DOUBLE_EQ(model.CeilingShift(tilt), -TiltModel(0.14, 2.6).CeilingShift(-tilt));
}

TEST(TiltModel, AgreesWithARayFromTheTiltedCamera) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const TiltedRobot robot(random);
    const TiltModel model = robot.Model();
    const Eigen::Isometry3d T = Pitched(robot);
    const Eigen::Vector3d foot = T * Eigen::Vector3d::Zero();
    const Eigen::Vector3d camera = T * Eigen::Vector3d(0, 0, robot.camera_height_m);
    const Eigen::Vector3d view = T.linear() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d at_ceiling = MeetPlane(camera, view, robot.ceiling_height_m);
    EXPECT_NEAR(model.CeilingShift(robot.tilt_rad), at_ceiling.x() - foot.x(), 1e-9);
    EXPECT_NEAR(model.MastLength(robot.tilt_rad, robot.camera_height_m),
                (camera - MeetPlane(camera, view, 0)).norm(),
                1e-9);
    EXPECT_NEAR(model.CameraHeight(robot.tilt_rad, robot.camera_height_m), camera.z(), 1e-9);
    // Frame B is level, with its camera at x_b; frame A is the tilted one.
    const double x_b = std::uniform_real_distribution<double>(-1, 1)(random);
    const double seen_motion_m = x_b - at_ceiling.x();
    EXPECT_NEAR(model.BaseShift(robot.tilt_rad, robot.camera_height_m, seen_motion_m),
                x_b - camera.x(),
                1e-9);
  }
}

// Left side down is a negative turn about x (REP-103 rolls the left side up).
TEST(TiltModel, IsTheSameForRollAlongY) {
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    const TiltedRobot robot(random);
    const double roll_rad = -robot.tilt_rad;
    const Eigen::Isometry3d T =
        TurnAbout({0, robot.pivot_m, 0}, {roll_rad, Eigen::Vector3d::UnitX()});
    const Eigen::Vector3d foot = T * Eigen::Vector3d::Zero();
    const Eigen::Vector3d at_ceiling =
        MeetPlane(foot, T.linear() * Eigen::Vector3d::UnitZ(), robot.ceiling_height_m);
    EXPECT_NEAR(robot.Model().CeilingShift(robot.tilt_rad), at_ceiling.y() - foot.y(), 1e-9);
  }
}

TEST(TiltModel, SlopesAreTheDerivatives) {
  std::mt19937 random(3);
  const double step = 1e-5;
  for (int i = 0; i < 500; ++i) {
    const TiltedRobot robot(random);
    const TiltModel model = robot.Model();
    const double d = robot.camera_height_m;
    const double climb =
        model.CameraHeight(robot.tilt_rad + step, d) - model.CameraHeight(robot.tilt_rad - step, d);
    EXPECT_NEAR(model.CameraHeightSlope(robot.tilt_rad, d), climb / (2 * step), 1e-7);
    const double shift = model.BaseShift(robot.tilt_rad + step, d, 0.3) -
                         model.BaseShift(robot.tilt_rad - step, d, 0.3);
    EXPECT_NEAR(model.BaseShiftSlope(robot.tilt_rad, d), shift / (2 * step), 1e-7);
  }
}

// T_d = h tilt - a tilt^2 + O(tilt^3), smooth through 0.
TEST(TiltModel, IsLinearForSmallTilts) {
  std::mt19937 random(4);
  for (int i = 0; i < 200; ++i) {
    const TiltedRobot robot(random);
    const TiltModel model = robot.Model();
    for (const double tilt : {-1e-3, -1e-6, 1e-9, 1e-4}) {
      EXPECT_NEAR(model.CeilingShift(tilt),
                  robot.ceiling_height_m * tilt - robot.pivot_m * tilt * tilt,
                  robot.ceiling_height_m * (std::abs(tilt * tilt * tilt) + 1e-15 * std::abs(tilt)));
    }
    EXPECT_EQ(model.CeilingShift(0), 0);
    EXPECT_EQ(model.MastLength(0, robot.camera_height_m), robot.camera_height_m);
    EXPECT_EQ(model.CameraHeight(0, robot.camera_height_m), robot.camera_height_m);
    EXPECT_EQ(model.BaseShift(0, robot.camera_height_m, 0.7), 0.7);
  }
}

// Also under the lowest ceiling that is allowed, where the slope nearly vanishes at one end.
TEST(TiltModel, TheShiftIncreasesWithTheTilt) {
  for (const double pivot : {-1.0, 1.0}) {
    const TiltModel model(pivot, 1.1001);
    for (int i = -1000; i < 1000; ++i) {
      EXPECT_LT(model.CeilingShift(kMaxTiltRad * i / 1000),
                model.CeilingShift(kMaxTiltRad * (i + 1) / 1000));
    }
  }
}

TEST(TiltModel, RefusesImpossibleRobots) {
  EXPECT_EQ(ErrorOf([] { TiltModel(2, 1); }),
            "tilt model: ceiling_height_m = 1, must be > 0 and > 1.1 |pivot_m| = 2.2; correct h or "
            "a in the rig, in metres");
  EXPECT_EQ(ErrorOf([] { TiltModel(kNan, 1); }),
            "tilt model: pivot_m = nan, must be finite; correct a in the rig");
  for (const double height : {0.0, -2.6, kNan, kInfinity}) {
    EXPECT_THROW(TiltModel(0, height), InputError) << height;
  }
  EXPECT_THROW(TiltModel(-2, 2.1), InputError);
}

TEST(TiltModel, RefusesTiltsAndCamerasOutOfRange) {
  const TiltModel model(0.14, 2.6);
  EXPECT_EQ(ErrorOf([&] { return model.CeilingShift(4.64); }),
            "tilt model: tilt_rad = 4.64, must be in [-pi/4, pi/4]; give radians");
  EXPECT_EQ(ErrorOf([&] { return model.MastLength(0.1, 45); }),
            "tilt model: camera_height_m = 45, must be between the floor and the ceiling at 2.6; "
            "correct d in the rig, in metres");
  for (const double tilt : {-0.8, 0.8, kNan}) {
    EXPECT_THROW((void)model.CeilingShift(tilt), InputError);
    EXPECT_THROW((void)model.MastLength(tilt, 0.45), InputError);
    EXPECT_THROW((void)model.CameraHeight(tilt, 0.45), InputError);
    EXPECT_THROW((void)model.BaseShift(tilt, 0.45, 0), InputError);
  }
  for (const double height : {0.0, -0.45, 2.6, kNan}) {
    EXPECT_THROW((void)model.CameraHeight(0.1, height), InputError) << height;
  }
}

}  // namespace
}  // namespace ceilmap::compensation
