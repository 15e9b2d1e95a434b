#include "localization/compass/travel_track.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "calib/base/pose2.hpp"

namespace ceilmap::compass {
namespace {

using std::numbers::pi;

/// Angle between two directions either of which may be reversed.
double Apart(double a, double b) {
  return std::abs(WrapAngle(2 * (a - b))) / 2;
}

TEST(TravelTrack, OfUnknownTravelTakesAnArc) {
  TravelTrack track;
  track.Move(std::nullopt);
  const TravelTrack::Spot start = track.Arrive(0);
  track.Move(std::nullopt);
  EXPECT_EQ(track.Direction(), 0);
  // On a quarter of a circle to the left the start lies half a quarter to the right.
  EXPECT_NEAR(track.DirectionFrom(start, pi / 2, pi / 2), -pi / 4, 1e-12);
}

TEST(TravelTrack, OfKnownTravelTakesTheChord) {
  const Pose2 poses[] = {{2, 1, 0.3}, {2.5, 1.5, 1}, {2.4, 2.5, -2}, {1, 3, 3}};
  TravelTrack track;
  track.Move(std::nullopt);
  const TravelTrack::Spot start = track.Arrive(poses[0].yaw);
  for (int i = 1; i < 4; ++i) {
    track.Move((poses[i].Inverse() * poses[i - 1]).Translation() * -1);
    const Eigen::Vector2d moved = poses[i].Inverse() * poses[0].Translation();
    const double chord = std::atan2(moved.y(), moved.x());
    EXPECT_LT(Apart(track.DirectionFrom(start, 0.1, poses[i].yaw), chord), 1e-9) << i;
    (void)track.Arrive(poses[i].yaw);
  }
}

TEST(TravelTrack, KeepsItsDirectionWhileItStands) {
  TravelTrack track;
  track.Move(Eigen::Vector2d(0, 0.1));
  (void)track.Arrive(0);
  track.Move(Eigen::Vector2d(0, 0));
  EXPECT_DOUBLE_EQ(track.Direction(), pi / 2);
  const TravelTrack::Spot here = track.Arrive(0);
  EXPECT_DOUBLE_EQ(track.DirectionFrom(here, 0.2, 0.2), pi / 2 - 0.1);
}

TEST(TravelTrack, DoesNotComparePlacesAcrossUnknownTravel) {
  TravelTrack track;
  track.Move(Eigen::Vector2d(0, 0.1));
  const TravelTrack::Spot before = track.Arrive(0);
  track.Move(std::nullopt);
  (void)track.Arrive(0);
  track.Move(Eigen::Vector2d(1, 1));
  EXPECT_DOUBLE_EQ(track.DirectionFrom(before, 0.5, 0.5), pi / 4 - 0.25);
}

}  // namespace
}  // namespace ceilmap::compass
