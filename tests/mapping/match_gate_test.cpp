#include "mapping/match_gate.hpp"

#include <gtest/gtest.h>

namespace ceilmap::mapping {
namespace {

constexpr MatchQuality kGood{1.0, 0.75, 0.8};

TEST(MatchGate, IsWhatIsTypicalOfTheRightOnes) {
  MatchGate standard;
  for (int i = 0; i < 9; ++i) standard.Add(kGood);
  standard.Add({0.5, 0.3, 3});  // one of them may be bad
  EXPECT_TRUE(standard.Accepts(kGood));
  EXPECT_TRUE(standard.Accepts({0.94, 0.67, 0.99}));
  EXPECT_FALSE(standard.Accepts({0.90, 0.75, 0.8})) << "blocks that do not agree";
  EXPECT_FALSE(standard.Accepts({1.0, 0.60, 0.8})) << "grain that is not the same";
  EXPECT_FALSE(standard.Accepts({1.0, 0.75, 1.1})) << "things that are not there";
}

TEST(MatchGate, FollowsTheLight) {
  MatchGate standard;
  for (int i = 0; i < 50; ++i) standard.Add(kGood);
  constexpr MatchQuality kDusk{0.95, 0.5, 1.2};
  EXPECT_FALSE(standard.Accepts(kDusk));
  for (int i = 0; i < MatchGate::kRemembered; ++i) standard.Add(kDusk);
  EXPECT_TRUE(standard.Accepts(kDusk));
}

TEST(MatchGate, HasALimitHoweverBadTheRightOnesAre) {
  MatchGate standard;
  for (int i = 0; i < 9; ++i) standard.Add({0.6, 0.4, 2.5});
  EXPECT_FALSE(standard.Accepts({0.6, 0.4, 2.5}));
}

TEST(MatchGate, HoldsBeforeAnythingIsKnown) {
  const MatchGate standard;
  EXPECT_TRUE(standard.Accepts(kGood));
  EXPECT_FALSE(standard.Accepts({0.8, 0.75, 0.8}));
  EXPECT_FALSE(standard.Accepts({1.0, 0.5, 0.8}));
  EXPECT_FALSE(standard.Accepts({1.0, 0.75, 1.7}));
}

TEST(MatchQuality, MedianIsOfEachNumberByItself) {
  const MatchQuality median = Median({{0.1, 0.9, 2}, {0.2, 0.8, 3}, {0.3, 0.7, 1}});
  EXPECT_EQ(median.inlier_ratio, 0.2);
  EXPECT_EQ(median.peak, 0.8);
  EXPECT_EQ(median.dissimilarity, 2);
  EXPECT_EQ(Median({}).peak, 0);
}

}  // namespace
}  // namespace ceilmap::mapping
