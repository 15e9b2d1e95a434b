#include "mapping/keyframe_headings.hpp"

#include <gtest/gtest.h>

#include "calib/error.hpp"
#include "mapping/heading_trust.hpp"

namespace ceilmap::mapping {
namespace {

constexpr double kNoise = 0.01;
constexpr double kSingles = 2 * kNoise * kNoise;

TEST(KeyframeHeadings, TellTurnsEitherWay) {
  KeyframeHeadings headings(kNoise);
  headings.Add(3, {0.5, 1e-9});
  headings.Add(4, {1.0, 0.01});
  headings.Add(7, {-3.0, 0.04});
  const auto on = headings.Turn(4, 7);
  ASSERT_TRUE(on);
  EXPECT_NEAR(on->turn_rad, 2 * 3.14159265358979 - 4, 1e-9);
  EXPECT_NEAR(on->variance_rad2, 0.03 + kSingles, 1e-9) << "what it drifted in between";
  const auto back = headings.Turn(7, 4);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->turn_rad, -on->turn_rad, 1e-12);
  EXPECT_NEAR(back->variance_rad2, on->variance_rad2, 1e-12);
}

TEST(KeyframeHeadings, KnowWhereTheCompassWasBestInBetween) {
  KeyframeHeadings headings(kNoise);
  headings.Add(0, {0, 1e-9});
  headings.Add(1, {0, 0.04});
  headings.Add(2, {0, 0.01});
  headings.Add(3, {0, 0.04});
  EXPECT_NEAR(headings.Turn(1, 3)->variance_rad2, 0.06 + kSingles, 1e-9);
}

TEST(KeyframeHeadings, KnowNothingOfKeyframesWithoutOne) {
  KeyframeHeadings headings(kNoise);
  EXPECT_FALSE(headings.Turn(0, 1));
  headings.Add(1, {0, 0.01});
  headings.Add(3, {0, 0.01});
  EXPECT_FALSE(headings.Turn(0, 1));
  EXPECT_FALSE(headings.Turn(1, 2));
  EXPECT_FALSE(headings.Turn(1, 4));
  EXPECT_TRUE(headings.Turn(1, 3));
}

TEST(HeadingTrust, OnlyAnotherOrientationContradicts) {
  const HeadingTrust trust;
  const calib::HeadingTurn compass{1, 1e-4};
  EXPECT_FALSE(Contradict(compass, {1.2, 0}, trust)) << "20 sigmas, but no quarter turn";
  EXPECT_TRUE(Contradict(compass, {1.3, 0}, trust));
  EXPECT_TRUE(Contradict(compass, {-2.2, 0}, trust));
  EXPECT_FALSE(Contradict(compass, {2.5, 0.1}, trust)) << "the other may be far off";
  EXPECT_FALSE(Contradict({1, 0.1}, {2.5, 0}, trust));
  EXPECT_FALSE(Contradict({3.1, 1e-4}, {-3.1, 0}, trust)) << "over the seam";
}

TEST(HeadingTrust, RefusesImpossibleValues) {
  HeadingTrust trust;
  trust.max_sigmas = 0;
  EXPECT_THROW(trust.Validate(), calib::InputError);
}

}  // namespace
}  // namespace ceilmap::mapping
