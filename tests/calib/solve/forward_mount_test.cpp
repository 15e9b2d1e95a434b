#include "calib/solve/forward_mount.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "calib/base/tilt.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kFocalPx = 500;

Matrix3d Turned(double yaw, double pitch_up, double roll) {
  Matrix3d level;  // points along base x
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) *
         Eigen::AngleAxisd(-pitch_up, Vector3d::UnitY()) *
         Eigen::AngleAxisd(roll, Vector3d::UnitX()) * level;
}

Isometry3d Start() {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = Turned(0, 0, 0);
  T.translation() << 0.05, 0, 0.45;
  return T;
}

Isometry3d Truth() {
  Isometry3d T = Start();
  T.linear() = Turned(4 * kRadPerDeg, 7 * kRadPerDeg, -2 * kRadPerDeg);
  return T;
}

/// Points in a room before and around the robot, seen by the camera of the truth.
class Room {
 public:
  Room(unsigned seed, double noise_px) : random_(seed), noise_(noise_px / kFocalPx) {
    std::uniform_real_distribution<double> around(-6, 6);
    std::uniform_real_distribution<double> up(0, 2.5);
    for (int i = 0; i < 600; ++i)
      points_.emplace_back(around(random_), around(random_), up(random_));
  }

  MotionWithMatches Observe(const Isometry3d& T_room_first, const Isometry3d& T_room_second) {
    MotionWithMatches motion;
    motion.T_first_second = T_room_first.inverse() * T_room_second;
    const Isometry3d first = (T_room_first * Truth()).inverse();
    const Isometry3d second = (T_room_second * Truth()).inverse();
    for (const Vector3d& point : points_) {
      const Vector3d a = first * point;
      const Vector3d b = second * point;
      if (!Shows(a) || !Shows(b)) continue;
      motion.matches.push_back({Noisy(a), Noisy(b)});
    }
    return motion;
  }

 private:
  static bool Shows(const Vector3d& p) {
    return p.z() > 0.5 && std::abs(p.x()) < 0.6 * p.z() && std::abs(p.y()) < 0.45 * p.z();
  }
  Vector2d Noisy(const Vector3d& p) {
    return p.hnormalized() + noise_ * Vector2d(normal_(random_), normal_(random_));
  }

  std::mt19937 random_;
  double noise_;
  std::normal_distribution<double> normal_;
  std::vector<Vector3d> points_;
};

/// About the axle, 0.14 m behind the mast.
Isometry3d OnTheSpot(double yaw) {
  return ToSpace({0.14 * std::cos(yaw), 0.14 * std::sin(yaw), yaw}, {});
}

Isometry3d Ahead(double distance, double pitch_down = 0) {
  Tilt tilt;
  tilt.pitch_rad = pitch_down;
  tilt.lift_m = 0.14 * std::sin(-pitch_down);
  return ToSpace({distance - 1, 0, 0}, tilt);
}

std::vector<MotionWithMatches> Spin(Room& room) {
  std::vector<MotionWithMatches> motions;
  for (int i = 0; i < 24; ++i) {
    motions.push_back(
        room.Observe(OnTheSpot(15 * kRadPerDeg * i), OnTheSpot(15 * kRadPerDeg * (i + 0.7))));
  }
  return motions;
}

std::vector<MotionWithMatches> Straight(Room& room) {
  std::vector<MotionWithMatches> motions;
  for (int i = 0; i < 16; ++i)
    motions.push_back(room.Observe(Ahead(0.1 * i), Ahead(0.1 * i + 0.4)));
  return motions;
}

std::vector<MotionWithMatches> OverAStep(Room& room) {
  std::vector<MotionWithMatches> motions;
  for (int i = 0; i < 16; ++i) {
    const double pitch = -4 * kRadPerDeg * std::sin(std::numbers::pi * i / 15);
    motions.push_back(room.Observe(Ahead(0.02 * i), Ahead(0.02 * i + 0.3, pitch)));
  }
  return motions;
}

ForwardMountParams Params() {
  ForwardMountParams params;
  params.focal_px = kFocalPx;
  params.sigma_floor_px = 1e-3;
  params.systematic_px = 0;
  params.systematic_rad = 0;
  params.lens_sigma_px = 0;
  return params;
}

/// A small turn about base's axes.
Vector3d ErrorOf(const ForwardMount& mount) {
  const Eigen::AngleAxisd off(mount.R_base_cam * Truth().linear().transpose());
  return off.angle() * off.axis();
}

void Append(std::vector<MotionWithMatches>& motions, const std::vector<MotionWithMatches>& more) {
  motions.insert(motions.end(), more.begin(), more.end());
}

TEST(ForwardMount, FindsTheTurnOfExactMatches) {
  Room room(1, 0);
  std::vector<MotionWithMatches> motions = Spin(room);
  Append(motions, Straight(room));
  const ForwardMount mount = SolveForwardMount(motions, Start(), Params());
  ASSERT_TRUE(mount.ok);
  EXPECT_LT(ErrorOf(mount).norm(), 1e-5);
  EXPECT_EQ(mount.inliers, mount.matches);
}

TEST(ForwardMount, AStepGivesAllThreeAngles) {
  Room room(2, 0.1);
  const ForwardMount mount = SolveForwardMount(OverAStep(room), Start(), Params());
  ASSERT_TRUE(mount.ok);
  EXPECT_LT(ErrorOf(mount).norm(), 0.1 * kRadPerDeg);
  EXPECT_LT(std::sqrt(mount.covariance.diagonal().maxCoeff()), 0.1 * kRadPerDeg);
}

TEST(ForwardMount, ErrorsAreAsLargeAsTheirDeviations) {
  double sum = 0;
  constexpr int kTimes = 8;
  for (int i = 0; i < kTimes; ++i) {
    Room room(10 + static_cast<unsigned>(i), 0.2);
    std::vector<MotionWithMatches> motions = Spin(room);
    Append(motions, Straight(room));
    const ForwardMount mount = SolveForwardMount(motions, Start(), Params());
    ASSERT_TRUE(mount.ok);
    EXPECT_NEAR(mount.sigma_px, 0.28, 0.06);  // of two points, one axis
    const Vector3d error = ErrorOf(mount);
    sum += error.dot(mount.covariance.ldlt().solve(error)) / 3;
  }
  // Curvature and scatter both count, so that deviations are rather too large.
  EXPECT_LT(sum / kTimes, 1.5);
  EXPECT_GT(sum / kTimes, 0.1);
}

TEST(ForwardMount, AStraightDriveDoesNotGiveTheRoll) {
  Room room(3, 0.1);
  const ForwardMount mount = SolveForwardMount(Straight(room), Start(), Params());
  ASSERT_TRUE(mount.ok);
  EXPECT_GT(std::sqrt(mount.covariance(0, 0)), 1 * kRadPerDeg);
  // Where the robot drives to is known in the image all the same.
  const Vector3d ahead = mount.R_base_cam.transpose() * Vector3d::UnitX();
  const Vector3d truth = Truth().linear().transpose() * Vector3d::UnitX();
  EXPECT_LT(std::acos(ahead.dot(truth)), 0.1 * kRadPerDeg);
}

TEST(ForwardMount, ACameraOverTheAxleOnlyTurns) {
  Room room(4, 0.1);
  std::vector<MotionWithMatches> motions;
  Isometry3d start = Start();
  start.translation().x() = 0;
  for (int i = 0; i < 24; ++i) {
    // The mast above the axle: base turns about its own origin.
    const auto turn = [](double yaw) {
      return ToSpace({-0.05 * std::cos(yaw), -0.05 * std::sin(yaw), yaw}, {});
    };
    motions.push_back(room.Observe(turn(15 * kRadPerDeg * i), turn(15 * kRadPerDeg * (i + 0.7))));
    // Observe() has the camera 0.05 m ahead of base: it stands on the axis, and only turns.
  }
  const ForwardMount mount = SolveForwardMount(motions, Truth(), Params());
  ASSERT_TRUE(mount.ok);
  EXPECT_LT(ErrorOf(mount).norm(), 0.05 * kRadPerDeg);
}

TEST(ForwardMount, WhatMovesByItselfIsLeftOut) {
  Room room(5, 0.1);
  std::vector<MotionWithMatches> motions = OverAStep(room);
  for (std::size_t k = 0; k < motions.size(); ++k) {
    // A person walks to and fro.
    const double shift = k % 2 == 0 ? 0.03 : -0.03;
    std::vector<Match>& matches = motions[k].matches;
    for (std::size_t i = 0; i < matches.size(); i += 4) matches[i].second += Vector2d(shift, 0.01);
  }
  const ForwardMount mount = SolveForwardMount(motions, Start(), Params());
  ASSERT_TRUE(mount.ok);
  EXPECT_LT(ErrorOf(mount).norm(), 0.15 * kRadPerDeg);
  EXPECT_LT(mount.inliers, 8 * mount.matches / 10);
}

TEST(ForwardMount, WhatAllMatchesAreOffByIsInItsDeviation) {
  Room room(6, 0.05);
  std::vector<MotionWithMatches> motions = Spin(room);
  Append(motions, Straight(room));
  ForwardMountParams params = Params();
  const ForwardMount without = SolveForwardMount(motions, Start(), params);
  params.systematic_px = 0.1;
  const ForwardMount with = SolveForwardMount(motions, Start(), params);
  for (MotionWithMatches& motion : motions) {
    for (Match& match : motion.matches) match.second.y() += 0.1 / kFocalPx;
  }
  const ForwardMount shifted = SolveForwardMount(motions, Start(), Params());
  const double change = (ErrorOf(shifted) - ErrorOf(without)).norm();
  EXPECT_GT(change, 2 * std::sqrt(without.covariance.trace()));
  EXPECT_LT(change, 1.2 * std::sqrt(with.covariance.trace()));
}

TEST(ForwardMount, TooLittle) {
  Room room(7, 0);
  EXPECT_FALSE(SolveForwardMount({}, Start(), Params()).ok);
  EXPECT_FALSE(SolveForwardMount({room.Observe(Ahead(0), Ahead(0.4))}, Start(), Params()).ok);
}

}  // namespace
}  // namespace ceilmap::calibration
