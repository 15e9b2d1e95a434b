#include "localization/heading_fusion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calib/base/error.hpp"

namespace ceilmap::localization {
namespace {

TEST(HeadingFusion, OfTheMapIsTakenAsItIs) {
  HeadingFusion fusion;
  const auto yaw = fusion.InMap({1, 0.01, HeadingFrame::kMap}, 5);
  ASSERT_TRUE(yaw);
  EXPECT_EQ(yaw->heading_rad, 1);
  EXPECT_EQ(yaw->variance_rad2, 0.01);
}

TEST(HeadingFusion, LearnsAnUnknownZeroFromAPose) {
  HeadingFusion fusion;
  EXPECT_FALSE(fusion.InMap({1, 0.01}, 5));
  fusion.Learn({1, 0.01}, 3, 0.002, 5);
  const auto yaw = fusion.InMap({2.5, 0.01}, 5);
  ASSERT_TRUE(yaw);
  EXPECT_NEAR(yaw->heading_rad, 4.5 - 2 * std::acos(-1.0), 1e-12);
  EXPECT_NEAR(yaw->variance_rad2, 0.022, 1e-12);
  // The zero wanders.
  EXPECT_NEAR(fusion.InMap({2.5, 0.01}, 105)->variance_rad2, 0.022 + 100 * 1e-5, 1e-12);
  fusion.Learn({1, 0.001}, 1, 0.001, 106);
  EXPECT_NEAR(fusion.InMap({0.5, 0.01}, 106)->heading_rad, 0.5, 1e-12);
}

TEST(HeadingFusion, TheDriftBeforeTheZeroWasLearntCancels) {
  // A compass counts from its first frame, where it was right by definition, and drifts from there.
  HeadingParams params;
  params.drift_rad2_per_s = 0;
  HeadingFusion fusion(params);
  EXPECT_FALSE(fusion.InMap({0, 1e-9}, 0));
  EXPECT_FALSE(fusion.InMap({0.2, 0.04}, 100));
  fusion.Learn({0.2, 0.04}, 1.5, 1e-6, 100);
  const auto yaw = fusion.InMap({0.7, 0.041}, 110);
  ASSERT_TRUE(yaw);
  EXPECT_NEAR(yaw->heading_rad, 2.0, 1e-12);
  EXPECT_NEAR(yaw->variance_rad2, 0.001 + 2 * 1e-4 + 1e-6, 1e-9) << "and not 0.081";
}

TEST(HeadingFusion, DriftIsCountedThroughMomentsWhenNothingWasLearnt) {
  HeadingParams params;
  params.drift_rad2_per_s = 0;
  HeadingFusion fusion(params);
  fusion.Learn({0, 1e-9}, 0, 1e-6, 0);
  fusion.Learn({0, 0.04}, 0, 1e-6, 50);
  (void)fusion.InMap({0, 0.01}, 60);  // an old view was seen again, and left
  EXPECT_NEAR(fusion.InMap({0, 0.04}, 70)->variance_rad2, 0.06 + 2e-4 + 1e-6, 1e-9);
}

TEST(HeadingFusion, ForgetsTheZero) {
  HeadingFusion fusion;
  fusion.Learn({1, 0.01}, 3, 0.002, 5);
  fusion.Forget();
  EXPECT_FALSE(fusion.InMap({1, 0.01}, 6));
}

TEST(HeadingFusion, RefusesAnImpossibleDrift) {
  HeadingParams params;
  params.drift_rad2_per_s = -1;
  EXPECT_THROW(HeadingFusion{params}, InputError);
  params.drift_rad2_per_s = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(HeadingFusion{params}, InputError);
  params = {};
  params.noise_rad = 0;
  EXPECT_THROW(HeadingFusion{params}, InputError);
}

}  // namespace
}  // namespace ceilmap::localization
