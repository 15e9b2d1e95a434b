#include "calib/nominal_rig.hpp"

#include <gmock/gmock.h>

#include <functional>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/rig_checks.hpp"

namespace ceilmap::calib {
namespace {

std::string RefusalOf(const NominalCamera& camera) {
  try {
    NominalRig({640, 480}, camera);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// tan(45 deg) = 1: half of the width is seen at the same distance.
TEST(NominalRig, HasTheFieldOfViewAndTheScale) {
  const Rig rig = NominalRig({640, 480}, {90 * kRadPerDeg, 2.6, 0.6});
  ASSERT_TRUE(rig.up);
  EXPECT_NEAR(rig.up->camera.fx, 320, 1e-6);
  EXPECT_EQ(rig.up->camera.fx, rig.up->camera.fy);
  EXPECT_EQ(rig.up->camera.cx, 319.5);
  EXPECT_EQ(rig.up->camera.cy, 239.5);
  EXPECT_EQ(rig.axle_behind_mast_m, 0);
  const CeilingView view(*rig.up, rig.ceiling_height_m);
  EXPECT_NEAR(640 * view.MetresPerPixel(), 4, 1e-9);
  EXPECT_FALSE(view.NeedsRectification());
  // The top of the image is towards the front: (0, -1) in the view is ahead.
  EXPECT_NEAR(
      (view.T_base_view() * Eigen::Vector2d(0, -1) - Eigen::Vector2d(1, 0)).norm(), 0, 1e-9);
  EXPECT_TRUE(RigWarnings(rig).empty());
}

TEST(NominalRig, ItsTextReadsBack) {
  const Rig rig = NominalRig({1280, 720}, {63.5 * kRadPerDeg, 3.1, 0});
  const Rig read = ParseRig(rig.source_yaml, "rig.yaml");
  EXPECT_EQ(read.up->camera.Matrix(), rig.up->camera.Matrix());
  EXPECT_EQ(read.ceiling_height_m, 3.1);
  EXPECT_EQ(read.up->T_base_cam.translation().z(), 0);
}

TEST(NominalRig, RefusesWhatCannotBe) {
  EXPECT_EQ(RefusalOf({4 * kRadPerDeg, 2.6, 0}), "field of view = 4 deg, must be in 5..150");
  EXPECT_EQ(RefusalOf({151 * kRadPerDeg, 2.6, 0}), "field of view = 151 deg, must be in 5..150");
  EXPECT_EQ(RefusalOf({5 * kRadPerDeg, 60, 0}), "");
  EXPECT_EQ(RefusalOf({150 * kRadPerDeg, 2.6, 0}), "");
  EXPECT_EQ(RefusalOf({1, 2.6, 2.6}),
            "ceiling height = 2.6 m, must be above the camera (2.6 m) and at most 60 m");
  EXPECT_EQ(RefusalOf({1, 2600, 0}),
            "ceiling height = 2600 m, must be above the camera (0 m) and at most 60 m");
  EXPECT_EQ(RefusalOf({1, 2.6, -0.1}), "camera height = -0.1 m, must be >= 0, above the floor");
}

}  // namespace
}  // namespace ceilmap::calib
