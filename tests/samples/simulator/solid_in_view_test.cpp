#include "samples/simulator/solid_in_view.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

Vector3d Somewhere(Random& random, double low_m, double high_m) {
  return {random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(low_m, high_m)};
}

/// A bar or a rod of any direction, above the camera or, sometimes, partly behind it.
Solid SomeSolid(Random& random) {
  const double low_m = random.Uniform(0, 1) < 0.3 ? -3 : 0.5;
  const Vector3d from = Somewhere(random, low_m, 4);
  const Vector3d to = from + Somewhere(random, -1, 1);
  const double width_m = random.Uniform(0.05, 0.8);
  return random.Uniform(0, 1) < 0.5 ? Bar(from, to, width_m, random.Uniform(0.05, 0.8))
                                    : Rod(from, to, width_m);
}

/// The upward camera at the origin, turned and tilted.
Isometry3d SomeCamera(Random& random) {
  Isometry3d T_map_cam = Isometry3d::Identity();
  T_map_cam.rotate(Eigen::AngleAxisd(random.Uniform(-3, 3), Vector3d::UnitZ()));
  T_map_cam.rotate(Eigen::AngleAxisd(random.Uniform(-0.2, 0.2), Vector3d::UnitX()));
  return T_map_cam;
}

RayBatch SomeRays(Random& random) {
  RayBatch rays;
  rays.count = 200;
  for (int i = 0; i < rays.count; ++i) {
    rays.x[i] = static_cast<float>(random.Uniform(-1, 1));
    rays.y[i] = static_cast<float>(random.Uniform(-1, 1));
    rays.distance[i] = 3;
    rays.solid[i] = -1;
    rays.face[i] = -1;
  }
  return rays;
}

TEST(SolidInView, ManyRaysMeetItAsSingleOnes) {
  Random random(5, Purpose::kStructures);
  int hits = 0;
  for (int n = 0; n < 300; ++n) {
    const Isometry3d T_map_cam = SomeCamera(random);
    const SolidInView solid(SomeSolid(random), T_map_cam);
    RayBatch rays = SomeRays(random);
    solid.EnterNearer(rays, 7);
    for (int i = 0; i < rays.count; ++i) {
      const Vector3d ray = T_map_cam.linear() * Vector3d(rays.x[i], rays.y[i], 1);
      const auto one = solid.Enter(ray, 3);
      // At an outline either may miss.
      const bool sure = solid.Enter(ray + Vector3d(1e-4, 0, 0), 3).has_value() == one.has_value() &&
                        solid.Enter(ray - Vector3d(1e-4, 0, 0), 3).has_value() == one.has_value();
      if (!sure) continue;
      ASSERT_EQ(rays.solid[i] == 7, one.has_value()) << n << " " << i;
      if (!one) {
        EXPECT_EQ(rays.distance[i], 3);
        continue;
      }
      ++hits;
      EXPECT_NEAR(rays.distance[i], one->distance, 1e-4);
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST(SolidInView, RaysThatMeetItAreWithinItsBounds) {
  Random random(6, Purpose::kStructures);
  for (int n = 0; n < 300; ++n) {
    const Isometry3d T_map_cam = SomeCamera(random);
    const SolidInView solid(SomeSolid(random), T_map_cam);
    RayBatch rays = SomeRays(random);
    solid.EnterNearer(rays, 7);
    for (int i = 0; i < rays.count; ++i) {
      if (rays.solid[i] != 7) continue;
      EXPECT_TRUE(solid.MayShow());
      EXPECT_TRUE(solid.MayShowIn({rays.x[i] - 1e-5, rays.y[i] - 1e-5, 2e-5, 2e-5}));
    }
  }
}

TEST(SolidInView, IsNotSoughtFarFromADiagonalBar) {
  const SolidInView bar(Bar({-1, -1, 2}, {1, 1, 2}, 0.1, 0.1), Isometry3d::Identity());
  EXPECT_TRUE(bar.MayShowIn({0, 0, 0.01, 0.01}));
  EXPECT_FALSE(bar.MayShowIn({0.3, -0.3, 0.01, 0.01}));  // within the range of x and of y
  const SolidInView behind(Bar({-1, -1, -2}, {1, 1, -2}, 0.1, 0.1), Isometry3d::Identity());
  EXPECT_FALSE(behind.MayShow());
}

TEST(SolidInView, FacesHaveTheirLight) {
  Solid solid = Bar({-1, 0.5, 2}, {1, 0.5, 2}, 0.2, 0.2);
  solid.brightness = 1;
  const SolidInView bar(solid, Isometry3d::Identity());
  const auto light = [&](const Vector3d& direction) {
    const auto entry = bar.Enter(direction, 100);
    return entry ? bar.Light(bar.InSolid(entry->distance * direction), entry->face) : -1;
  };
  EXPECT_FLOAT_EQ(light({0, 0.25, 1}), 1);     // underside
  EXPECT_FLOAT_EQ(light({0, 0.2, 1}), 0.75F);  // long side towards the camera
  EXPECT_FLOAT_EQ(light({0, 0.1, 1}), -1);
}

}  // namespace
}  // namespace ceilmap::simulator
