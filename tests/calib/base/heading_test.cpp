#include "calib/base/heading.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace ceilmap {
namespace {

constexpr double kNoise = 0.01;
constexpr double kSingles = 2 * kNoise * kNoise;

HeadingTurn TurnOver(const std::vector<HeadingPrior>& headings, std::size_t marked) {
  HeadingSince since(kNoise);
  for (std::size_t i = 0; i < headings.size(); ++i) {
    since.Add(headings[i]);
    if (i == marked) since.Mark();
  }
  return since.Turn().value();
}

TEST(HeadingSince, HasNoTurnBeforeAMark) {
  HeadingSince since;
  EXPECT_FALSE(since.Turn());
  since.Mark();
  EXPECT_FALSE(since.Turn());
  since.Add({1, 0.1});
  EXPECT_FALSE(since.Turn());
  since.Mark();
  EXPECT_TRUE(since.Turn());
}

TEST(HeadingSince, TurnsTheShorterWay) {
  const HeadingTurn turn = TurnOver({{3, 1e-9}, {-3, 1e-9}}, 0);
  EXPECT_NEAR(turn.turn_rad, 2 * std::numbers::pi - 6, 1e-12);
}

TEST(HeadingSince, TheDriftBeforeTheMarkCancels) {
  // It has drifted by 11 degrees; from the mark on by one.
  const HeadingTurn turn = TurnOver({{0, 1e-9}, {1, 0.04}, {1.5, 0.0403}}, 1);
  EXPECT_NEAR(turn.turn_rad, 0.5, 1e-12);
  EXPECT_NEAR(turn.variance_rad2, 0.0003 + kSingles, 1e-9);
}

TEST(HeadingSince, DriftThatWasTakenOutAndCameAgainCountsTwice) {
  // An old view is seen again in between: the drifts before and after have little in common.
  const HeadingTurn turn = TurnOver({{0, 1e-9}, {1, 0.04}, {1, 0.01}, {1, 0.04}}, 1);
  EXPECT_NEAR(turn.variance_rad2, 0.03 + 0.03 + kSingles, 1e-9);
  // One that has just been taken out is common to both.
  EXPECT_NEAR(TurnOver({{0, 1e-9}, {1, 0.04}, {1, 0.01}}, 1).variance_rad2, 0.03 + kSingles, 1e-9);
}

TEST(HeadingSince, ADifferenceOfInaccurateHeadingsIsInaccurate) {
  const double variance = 0.0076;  // 5 degrees, always
  const HeadingTurn turn = TurnOver({{0, variance}, {1, variance}, {1.2, variance}}, 0);
  EXPECT_NEAR(turn.variance_rad2, 2 * variance, 1e-12);
}

TEST(HeadingSince, HoldsForARandomWalk) {
  // Of many compasses that drift by the same rule, the spread of the turns is what is claimed.
  constexpr int kCompasses = 4000;
  constexpr int kSteps = 30;
  constexpr double kStep = 0.02;
  constexpr int kMarked = 10;
  std::uint64_t state = 7;
  const auto uniform = [&state] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11U) * 0x1.0p-53 - 0.5;
  };
  double squares = 0;
  double claimed = 0;
  for (int n = 0; n < kCompasses; ++n) {
    HeadingSince since(1e-6);
    double drift = 0;
    for (int i = 0; i <= kSteps; ++i) {
      since.Add({drift, 1e-12 + i * kStep * kStep});
      if (i == kMarked) since.Mark();
      drift += kStep * std::sqrt(12.0) * uniform();
    }
    squares += std::pow(since.Turn()->turn_rad, 2) / kCompasses;
    claimed = since.Turn()->variance_rad2;
  }
  EXPECT_NEAR(squares / claimed, 1, 0.1);
}

}  // namespace
}  // namespace ceilmap
