#include "samples/simulator/debris.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include "calib/base/error.hpp"
#include "samples/simulator/drive.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Translation3d;
using Eigen::Vector3d;

/// Along x from (2, 3) to (6, 3), the mast 0.14 m before the axle.
Scene StraightScene() {
  Scene scene;
  scene.axle_behind_mast_m = 0.14;
  scene.path.kind = PathKind::kWaypoints;
  scene.path.waypoints_m = {{2, 3}, {6, 3}};
  scene.path.speed_m_s = 0.4;
  scene.camera.exposure_time_s = 0.03;
  scene.forward = DefaultForwardCamera();
  scene.forward->exposure_time_s = 0.05;
  return scene;
}

std::string ErrorOf(const Scene& scene) {
  try {
    (void)MakePath(scene);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(TiltAt, FollowsARaisedCosine) {
  // Rows of a rendered run whose bump of 0.4 m begins at 0.22 m, 0.02 m apart.
  const Debris debris{{{0.22, 0.4, 2.4, 0}}};
  const auto pitch_deg = [&](double distance_m) {
    return TiltAt(debris, distance_m).pitch_rad / kRadPerDeg;
  };
  EXPECT_EQ(pitch_deg(0.22), 0);
  EXPECT_NEAR(pitch_deg(0.24), 0.058732, 1e-6);
  EXPECT_NEAR(pitch_deg(0.26), 0.229180, 1e-6);
  EXPECT_NEAR(pitch_deg(0.40), 2.341268, 1e-6);
  EXPECT_NEAR(pitch_deg(0.42), 2.4, 1e-12);
  EXPECT_NEAR(pitch_deg(0.60), 0.058732, 1e-6);
  EXPECT_EQ(pitch_deg(0.62), 0);
  EXPECT_TRUE(TiltAt(debris, 0.1).IsLevel());
  EXPECT_TRUE(TiltAt(debris, 7).IsLevel());
}

TEST(TiltAt, BumpsThatOverlapAddUp) {
  const Debris debris{{{1, 1, 3, 0}, {1.25, 0.5, 1, -2}}};
  const Tilt tilt = TiltAt(debris, 1.5);
  EXPECT_NEAR(tilt.pitch_rad, 4 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(tilt.roll_rad, -2 * kRadPerDeg, 1e-12);
}

// Over a long way the spread is the stated one in the middle of a bump, where its two neighbours
// are at 0.
TEST(UnevenGround, TiltsAtRandom) {
  Debris debris;
  EXPECT_TRUE(UnevenGround(debris, 1, 100).empty());
  debris.uneven_deg = 2;
  debris.uneven_length_m = 0.8;
  debris.bumps = UnevenGround(debris, 1, 400);
  ASSERT_EQ(debris.bumps.size(), 1000U);
  double pitch2 = 0;
  double roll2 = 0;
  double both = 0;
  for (int i = 0; i < 1000; ++i) {
    const Tilt tilt = TiltAt(debris, 0.4 * i + 0.4);
    EXPECT_NEAR(tilt.pitch_rad, debris.bumps[i].pitch_deg * kRadPerDeg, 1e-9);
    pitch2 += std::pow(tilt.pitch_rad / kRadPerDeg, 2) / 1000;
    roll2 += std::pow(tilt.roll_rad / kRadPerDeg, 2) / 1000;
    both += tilt.pitch_rad * tilt.roll_rad / std::pow(kRadPerDeg, 2) / 1000;
  }
  EXPECT_NEAR(pitch2, 4, 0.6);
  EXPECT_NEAR(roll2, 4, 0.6);
  EXPECT_NEAR(both, 0, 0.5);
  EXPECT_NE(UnevenGround(debris, 2, 400)[5].pitch_deg, debris.bumps[5].pitch_deg);
}

TEST(UnevenGround, TiltsThePathAsItGoes) {
  Scene scene = StraightScene();
  scene.debris.uneven_deg = 1.5;
  const std::vector<Frame> frames = MakePath(scene);
  const std::vector<Bump> bumps = UnevenGround(scene.debris, scene.seed, PathLength(scene));
  const Frame& frame = frames[frames.size() / 2];
  const double driven_m = Drive({{2, 3}, {6, 3}}, scene.path).DistanceAt(frame.stamp_s - 100);
  const Tilt tilt = TiltAt({bumps}, driven_m);
  EXPECT_FALSE(tilt.IsLevel());
  EXPECT_NEAR((frame.T_map_base.linear() * Vector3d::UnitX()).z(), std::sin(tilt.pitch_rad), 1e-9);
}

TEST(TiltedBase, NoseUpLiftsTheMastAndLeftSideUpTipsItToTheRight) {
  const Isometry3d T_map_base = TiltedBase({1, 2, 0}, {5 * kRadPerDeg, 0}, 0.14);
  EXPECT_NEAR(T_map_base.translation().z(), 0.14 * std::sin(5 * kRadPerDeg), 1e-12);
  EXPECT_NEAR(T_map_base.translation().x(), 1 + 0.14 * std::cos(5 * kRadPerDeg), 1e-12);
  EXPECT_NEAR((T_map_base.linear() * Vector3d::UnitX()).z(), std::sin(5 * kRadPerDeg), 1e-12);
  const Isometry3d rolled = TiltedBase({1, 2, 0}, {0, 2 * kRadPerDeg}, 0.14);
  EXPECT_NEAR((rolled.linear() * Vector3d::UnitY()).z(), std::sin(2 * kRadPerDeg), 1e-12);
  EXPECT_NEAR(rolled.translation().z(), 0, 1e-12);
}

TEST(TiltedBase, WithoutTiltIsTheLevelPose) {
  const Pose2 axle{3, -2, 1.1};
  const Isometry3d level = StillFrame(0, axle * Pose2{0.2, 0, 0}).T_map_base;
  EXPECT_LT((TiltedBase(axle, {}, 0.2).matrix() - level.matrix()).norm(), 1e-15);
}

TEST(MakePathOverDebris, PosesAreTheFormula) {
  Scene scene = StraightScene();
  scene.path.waypoints_m = {{2, 3}, {5, 4}};
  scene.debris.bumps = {{0.5, 0.6, 4, 0}, {1.6, 0.8, 2, -3}};
  const Drive drive(scene.path.waypoints_m, scene.path);
  const double yaw = std::atan2(1, 3);
  const auto formula = [&](double time_s) -> Isometry3d {
    const double travelled = drive.DistanceAt(time_s);
    double pitch = 0;
    double roll = 0;
    for (const Bump& bump : scene.debris.bumps) {
      if (travelled < bump.start_m || travelled > bump.start_m + bump.length_m) continue;
      const double turn = 2 * std::numbers::pi * (travelled - bump.start_m) / bump.length_m;
      pitch += bump.pitch_deg * kRadPerDeg * (1 - std::cos(turn)) / 2;
      roll += bump.roll_deg * kRadPerDeg * (1 - std::cos(turn)) / 2;
    }
    return Translation3d(2 + travelled * std::cos(yaw), 3 + travelled * std::sin(yaw), 0) *
           AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(-pitch, Vector3d::UnitY()) *
           AngleAxisd(roll, Vector3d::UnitX()) * Translation3d(0.14, 0, 0);
  };
  int tilted = 0;
  for (const Frame& frame : MakePath(scene)) {
    const double time_s = frame.stamp_s - scene.path.start_stamp_s;
    EXPECT_LT((frame.T_map_base.matrix() - formula(time_s).matrix()).norm(), 1e-9);
    EXPECT_LT((frame.T_map_base_open.matrix() - formula(time_s - 0.015).matrix()).norm(), 1e-9);
    EXPECT_LT((frame.T_map_base_close.matrix() - formula(time_s + 0.015).matrix()).norm(), 1e-9);
    EXPECT_LT((frame.T_map_base_forward_open.matrix() - formula(time_s - 0.025).matrix()).norm(),
              1e-9);
    EXPECT_LT((frame.T_map_base_forward_close.matrix() - formula(time_s + 0.025).matrix()).norm(),
              1e-9);
    if (frame.T_map_base(2, 2) < 1) ++tilted;
  }
  EXPECT_NEAR(tilted, 1.4 / 0.4 * 10, 3);
}

TEST(MakePathOverDebris, BesideTheBumpsTheDriveIsTheLevelOneBitByBit) {
  Scene scene = StraightScene();
  const std::vector<Frame> level = MakePath(scene);
  scene.debris.bumps = {{1, 0.5, 4, 1}};
  const std::vector<Frame> bumpy = MakePath(scene);
  ASSERT_EQ(bumpy.size(), level.size());
  for (std::size_t i = 0; i < level.size(); ++i) {
    const double x = level[i].T_map_base.translation().x() - 2.14;
    if (x > 0.98 && x < 1.52) continue;
    EXPECT_EQ(bumpy[i].T_map_base.matrix(), level[i].T_map_base.matrix()) << i;
    EXPECT_EQ(bumpy[i].T_map_base_open.matrix(), level[i].T_map_base_open.matrix()) << i;
  }
}

TEST(MakePathOverDebris, DistanceIsThatOfTheAxleWithoutTurnsOnTheSpot) {
  Path path;
  const Drive drive({{0, 0}, {1, 0}, {1, 2}}, path);
  const double metre_s = 2 * std::sqrt(1 / 0.6);
  EXPECT_EQ(drive.DistanceAt(-1), 0);
  EXPECT_NEAR(drive.DistanceAt(metre_s / 2), 0.5, 1e-12);
  EXPECT_NEAR(drive.DistanceAt(metre_s), 1, 1e-12);
  EXPECT_NEAR(drive.DistanceAt(metre_s + 1.25), 1, 1e-12);  // half of the turn
  EXPECT_NEAR(drive.DistanceAt(drive.Duration()), 3, 1e-12);
  path.corner_radius_m = 0.5;
  const Drive round({{0, 0}, {1, 0}, {1, 2}}, path);
  EXPECT_NEAR(round.DistanceAt(round.Duration()), 2 + 0.25 * std::numbers::pi, 1e-9);
}

TEST(MakePathOverDebris, RefusesABumpThatIsNeverReached) {
  Scene scene = StraightScene();
  scene.debris.bumps = {{1, 0.5, 4, 0}, {4.5, 0.5, 4, 0}};
  EXPECT_EQ(ErrorOf(scene),
            "debris.bumps[1].start_m = 4.5, must be less than the 4.000 m of the path");
  scene.debris.bumps[1].start_m = 3.5;
  scene.path.max_frames = 3;  // not even the first one; the path itself has both
  EXPECT_EQ(ErrorOf(scene), "no error");
}

}  // namespace
}  // namespace ceilmap::simulator
