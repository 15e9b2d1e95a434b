#include "samples/simulator/deck_ribs.hpp"

#include <gmock/gmock.h>

#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Vector2d;

struct RibsInRay {
  float shade = 0;
  float rise = 0;
};

/// Ribs every 0.2 m, 0.05 m deep: troughs from 0.05 to 0.15 m, upper flanges from 0.064 to 0.136 m.
RibsInRay See(float y, float slope, float footprint_m = 1e-4F) {
  Ceiling ceiling;
  ceiling.rib_every_m = 0.2;
  ceiling.rib_depth_m = 0.05;
  RibsInRay seen;
  DeckRibs(ceiling).See(&y, &slope, &footprint_m, 1, &seen.shade, &seen.rise);
  return seen;
}

TEST(DeckRibs, FlangesAndSidesAreWhereTheyAre) {
  for (const float period : {-0.4F, 0.0F, 0.6F}) {
    EXPECT_NEAR(See(period + 0.049F, 0).shade, 1, 3e-4F);
    EXPECT_NEAR(See(period + 0.151F, 0).shade, 1, 3e-4F);
    EXPECT_NEAR(See(period + 0.1F, 0).shade, 0.7F, 3e-4F);
    EXPECT_NEAR(See(period + 0.1F, 0).rise, 0.05F, 2e-5F);
    EXPECT_NEAR(See(period + 0.051F, 0).shade, 0.55F, 3e-4F);
    EXPECT_NEAR(See(period + 0.149F, 0).shade, 0.85F, 3e-4F);
  }
  EXPECT_EQ(See(0.049F, 0).rise, 0);
}

TEST(DeckRibs, ObliqueRaysSeeOneSideOnly) {
  // To the right by 0.05 m within the depth: the left side is hidden, the right one fills 0.064 m.
  EXPECT_NEAR(See(0.051F, 1).shade, 0.7F, 3e-4F);
  EXPECT_NEAR(See(0.085F, 1).shade, 0.7F, 3e-4F);
  EXPECT_NEAR(See(0.087F, 1).shade, 0.85F, 3e-4F);
  EXPECT_NEAR(See(0.113F, -1).shade, 0.55F, 3e-4F);
}

TEST(DeckRibs, FootprintIsAveraged) {
  EXPECT_NEAR(See(0.05F, 0, 0.02F).shade, 0.5F + 0.5F * 0.55F, 1e-5F);
  EXPECT_NEAR(See(0.04F, 0, 0.02F).shade, 1, 1e-5F);
}

TEST(DeckRibs, MarkOnAnUpperFlangeIsHigher) {
  Scene scene = PlainScene();
  scene.ceiling.rib_every_m = 0.4;
  scene.ceiling.rib_depth_m = 0.1;
  // The ribs count from y = 0: the middle of an upper flange is at y = 4.2, of a lower one at 4.4.
  // Seen 0.3 m ahead and 0.2 m to the left.
  const auto displacement = [&](double y_m) {
    const auto light = [&](double brightness) {
      scene.ceiling.marks_at = {{6.3, y_m, 0.01, brightness}};
      return Renderer(scene).RenderLight(Level(6, y_m - 0.2, 0));
    };
    const Vector2d seen = CentreOfMark(light(0) - light(0.8), 0);
    return Vector2d(119.5 - seen.y(), seen.x() - 159.5);
  };
  EXPECT_LT((displacement(4.4) - Vector2d(0.3, 0.2) * 400 / 2.0).norm(), 0.02);
  EXPECT_LT((displacement(4.2) - Vector2d(0.3, 0.2) * 400 / 2.1).norm(), 0.03);
}

}  // namespace
}  // namespace ceilmap::simulator
