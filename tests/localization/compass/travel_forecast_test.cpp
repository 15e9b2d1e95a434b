#include "localization/compass/travel_forecast.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::compass {
namespace {

using std::numbers::pi;

TEST(TravelForecast, GoesOnAsItWent) {
  TravelForecast forecast;
  EXPECT_FALSE(forecast.Between(0, 0.1));
  // Facing along y and driving along x: to the right.
  forecast.Add(1.0, Pose2{2, 3, pi / 2});
  EXPECT_FALSE(forecast.Between(1, 1.1));
  forecast.Add(1.1, Pose2{2.2, 3, pi / 2});
  const auto travel = forecast.Between(1.2, 1.3);
  ASSERT_TRUE(travel);
  EXPECT_NEAR(travel->x(), 0, 1e-12);
  EXPECT_NEAR(travel->y(), -0.2, 1e-12);
}

TEST(TravelForecast, ACameraOffTheAxleTravelsInATurnOnTheSpot) {
  TravelForecast forecast({0.5, 0});
  forecast.Add(0, Pose2{1, 1, 0});
  forecast.Add(0.1, Pose2{1, 1, 0.1});
  const Eigen::Vector2d travel = forecast.Between(0.1, 0.2).value();
  EXPECT_NEAR(travel.y(), 0.5 * std::sin(0.1), 1e-12);
  EXPECT_NEAR(travel.x(), 0.5 * (1 - std::cos(0.1)), 1e-12);
}

TEST(TravelForecast, SaysNothingOfWhatItDoesNotKnow) {
  TravelForecast forecast;
  forecast.Add(0, Pose2{0, 0, 0});
  forecast.Add(0.1, Pose2{0.1, 0, 0});
  EXPECT_TRUE(forecast.Between(0.9, 1.0));
  EXPECT_FALSE(forecast.Between(1.1, 1.2)) << "too long ago";
  forecast.Add(0.2, std::nullopt);
  EXPECT_FALSE(forecast.Between(0.2, 0.3)) << "lost";
  forecast.Add(0.3, Pose2{5, 0, 0});
  EXPECT_FALSE(forecast.Between(0.3, 0.4)) << "found again, it may have jumped";
  forecast.Add(2.3, Pose2{6, 0, 0});
  EXPECT_FALSE(forecast.Between(2.3, 2.4)) << "two moments too far apart";
}

}  // namespace
}  // namespace ceilmap::compass
