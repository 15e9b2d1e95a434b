#include "calib/mirror.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap::calib {
namespace {

HyperbolicMirror Mirror() {
  return {.A_m = 0.028095,
          .B_m = 0.0234125,
          .C_m = 0.0365714941,
          .rim_radius_m = 0.04,
          .rim_radius_px = 225.623,
          .horizon_radius_px = 138.707};
}

Eigen::Vector3d Direction(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth),
          std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

// A ray that runs to one focus is reflected to the other one.
TEST(Mirror, ReflectsAsItsSurfaceDoes) {
  const HyperbolicMirror mirror = Mirror();
  for (double elevation = -80; elevation <= 25; elevation += 7) {
    const Eigen::Vector3d direction = Direction(0.7, elevation * kRadPerDeg);
    const auto p_cam = mirror.Reflection(direction);
    ASSERT_TRUE(p_cam) << elevation;
    const double r = p_cam->head<2>().norm();
    const double z = p_cam->z() - mirror.C_m;
    EXPECT_NEAR(std::pow(z / mirror.A_m, 2) - std::pow(r / mirror.B_m, 2), 1, 1e-9);
    EXPECT_GT(z, 0);
    const Eigen::Vector3d normal = Eigen::Vector3d(-p_cam->x() / (mirror.B_m * mirror.B_m),
                                                   -p_cam->y() / (mirror.B_m * mirror.B_m),
                                                   z / (mirror.A_m * mirror.A_m))
                                       .normalized();
    const Eigen::Vector3d incoming = -direction;
    const Eigen::Vector3d reflected = incoming - 2 * incoming.dot(normal) * normal;
    EXPECT_LT((reflected - -p_cam->normalized()).norm(), 1e-9) << elevation;
    EXPECT_NEAR(mirror.CameraSlope(elevation * kRadPerDeg), r / p_cam->z(), 1e-12);
    EXPECT_NEAR(mirror.Elevation(r / p_cam->z()), elevation * kRadPerDeg, 1e-7);  // C is rounded
  }
}

// The figures of a rig with a focal length of 520 px.
TEST(Mirror, HorizonAndRimAreWhereTheRigSaysThem) {
  const HyperbolicMirror mirror = Mirror();
  EXPECT_NEAR(520 * mirror.CameraSlope(0), mirror.horizon_radius_px, 1e-3);
  EXPECT_NEAR(520 * mirror.CameraSlope(mirror.RimElevation()), mirror.rim_radius_px, 1e-3);
  EXPECT_NEAR(mirror.RimElevation(), 25.4 * kRadPerDeg, 0.1 * kRadPerDeg);
}

TEST(Mirror, EndsAtItsRim) {
  const HyperbolicMirror mirror = Mirror();
  EXPECT_TRUE(mirror.Reflection(Direction(1, mirror.RimElevation())));
  EXPECT_FALSE(mirror.Reflection(Direction(1, mirror.RimElevation() + 0.001)));
  EXPECT_FALSE(mirror.Reflection(Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(mirror.Reflection(-Eigen::Vector3d::UnitZ()));
}

}  // namespace
}  // namespace ceilmap::calib
