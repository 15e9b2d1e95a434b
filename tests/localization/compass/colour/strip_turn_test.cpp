#include "localization/compass/colour/strip_turn.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/localization/compass/colour/coloured_room.hpp"

namespace ceilmap::colour {
namespace {

TEST(StripTurn, OfARobotThatTurns) {
  const ColouredRoom room;
  const calib::MountedCamera forward = ForwardCamera();
  for (const double turn : {0.0, 0.02, -0.05, 0.13, -0.3}) {
    StripTurn strip(forward);
    EXPECT_FALSE(strip.Next(room.Render(forward, {0, 0, 1})));
    const auto seen = strip.Next(room.Render(forward, {0, 0, 1 + turn}));
    ASSERT_TRUE(seen) << turn;
    EXPECT_NEAR(seen->turn_rad, turn, 0.001);
    EXPECT_NEAR(seen->ahead, 0, 0.01);
    EXPECT_LT(seen->difference, 0.1);
  }
}

TEST(StripTurn, DrivingAheadIsNoTurn) {
  const ColouredRoom room;
  const calib::MountedCamera forward = ForwardCamera();
  for (const double travelled_m : {0.05, 0.1, -0.1}) {
    StripTurn strip(forward);
    strip.Next(room.Render(forward, {0, 0, 0.4}));
    const auto seen = strip.Next(
        room.Render(forward, {travelled_m * std::cos(0.4), travelled_m * std::sin(0.4), 0.4}));
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->turn_rad, 0, 0.003) << travelled_m;
    EXPECT_NEAR(seen->ahead * room.Radius(), travelled_m, 0.3 * std::abs(travelled_m))
        << travelled_m;
  }
}

TEST(StripTurn, NoResultWithoutCommonContent) {
  const calib::MountedCamera forward = ForwardCamera();
  StripTurn strip(forward);
  strip.Next(ColouredRoom(1).Render(forward, {0, 0, 0}));
  EXPECT_FALSE(strip.Next(cv::Mat(240, 320, CV_8UC3, cv::Scalar::all(0)))) << "in the dark";
  EXPECT_FALSE(strip.Next(ColouredRoom(1).Render(forward, {0, 0, 0}))) << "after the dark";
  EXPECT_TRUE(strip.Next(ColouredRoom(1).Render(forward, {0, 0, 0.01})));
  strip.Reset();
  EXPECT_FALSE(strip.Next(ColouredRoom(1).Render(forward, {0, 0, 0.02})));
}

}  // namespace
}  // namespace ceilmap::colour
