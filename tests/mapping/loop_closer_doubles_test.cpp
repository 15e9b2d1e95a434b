// Perceptual aliasing: a loop closure of one pair of images can be contradicted by another pair.

#include <gtest/gtest.h>

#include <vector>

#include "mapping/loop_closer.hpp"
#include "tests/mapping/stops.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::Stop;
using synthetic::Stops;

constexpr int kPlaces = 4;             // of a room, without a view in common
constexpr int kCarried = 2 * kPlaces;  // the keyframe after the robot was carried

/// A robot that drives through room A (keyframes 0..3) and room B (4..7), is then carried to
/// another place (8), and drives through room A again from there (9..12). Its odometry from one
/// keyframe to the next is true to a few millimetres, but of the path on which it was carried
/// hardly anything.
class CarriedBack {
 public:
  /// @param doubles  Number of places of room B, the first ones, that are identical to those of
  /// room A.
  explicit CarriedBack(int doubles, const LoopCloserParams& params = Stops::ShortGap())
      : stops_({}, params) {
    for (int i = 0; i < kPlaces; ++i) Place({4.0 * i, 0, 0});
    for (int i = 0; i < kPlaces; ++i) {
      Place({4.0 * i, 6, 0});
      if (i < doubles) drive_.back().appears_at = {4.0 * i, 0, 0};
    }
    Place({-4, 0, 0});
    drive_.back().sigma = 3;
    drive_.back().sigma_rad = 0.1;
    // Not quite where it was the first time.
    for (int i = 0; i < kPlaces; ++i) Place({4.0 * i + 0.3, -0.2, 0.1});
  }

  /// Shows the places in their order, but of the second visit only this number.
  graph::LoopCounts Visit(int again) {
    for (int i = 0; i <= kCarried + again; ++i) stops_.Show(drive_[static_cast<std::size_t>(i)]);
    return stops_.Counts();
  }

  [[nodiscard]] double WorstEdge() const { return stops_.WorstEdge(); }

 private:
  void Place(const Pose2& T_map_base) { drive_.push_back({T_map_base, T_map_base}); }

  std::vector<Stop> drive_;
  Stops stops_;
};

TEST(LoopCloserDoubles, ASecondClosureConfirmsTheFirstWhereNothingContradicts) {
  const graph::LoopCounts one = CarriedBack(0).Visit(1);
  EXPECT_EQ(one.accepted, 0);
  EXPECT_EQ(one.unconfirmed, 1);
  CarriedBack drive(0);
  const graph::LoopCounts two = drive.Visit(2);
  EXPECT_EQ(two.accepted, 2);
  EXPECT_EQ(two.unconfirmed, 0);
  EXPECT_LT(drive.WorstEdge(), 0.01);
}

TEST(LoopCloserDoubles, ARoomThatIsThereTwiceIsNotRecognized) {
  // Each keyframe is found in both rooms; closures to one room contradict those to the other.
  const graph::LoopCounts counts = CarriedBack(kPlaces).Visit(kPlaces);
  EXPECT_EQ(counts.accepted, 0);
  EXPECT_EQ(counts.unconfirmed, 2 * kPlaces);
}

TEST(LoopCloserDoubles, ManyThatAgreeOutweighOneThatDoesNot) {
  // Only the first place has a double: 1 against 1, 2, 3 others.
  const graph::LoopCounts three = CarriedBack(1).Visit(3);
  EXPECT_EQ(three.accepted, 0);
  EXPECT_EQ(three.unconfirmed, 4);
  CarriedBack drive(1);
  const graph::LoopCounts four = drive.Visit(4);
  EXPECT_EQ(four.accepted, 4);
  EXPECT_EQ(four.unconfirmed, 1) << "the one to the wrong room";
  EXPECT_LT(drive.WorstEdge(), 0.01);
}

TEST(LoopCloserDoubles, TheParameterSaysHowMuchContradictionIsBorne) {
  LoopCloserParams params = Stops::ShortGap();
  params.judge.max_contradicting_ratio = 0.51;
  EXPECT_EQ(CarriedBack(1, params).Visit(2).accepted, 0);
  EXPECT_EQ(CarriedBack(1, params).Visit(3).accepted, 3) << "1 against 2";
  params.judge.max_contradicting_ratio = 0;
  EXPECT_EQ(CarriedBack(1, params).Visit(4).accepted, 0);
  EXPECT_EQ(CarriedBack(0, params).Visit(2).accepted, 2);
}

TEST(LoopCloserDoubles, AContradictionIsForgottenWithTheClosureThatMadeIt) {
  LoopCloserParams params = Stops::ShortGap();
  params.judge.confirm_within = 2;
  CarriedBack drive(1, params);
  const graph::LoopCounts counts = drive.Visit(4);
  EXPECT_EQ(counts.accepted, 3);
  EXPECT_EQ(counts.unconfirmed, 2) << "both that the first place was found by";
  EXPECT_LT(drive.WorstEdge(), 0.01);
}

}  // namespace
}  // namespace ceilmap::mapping
