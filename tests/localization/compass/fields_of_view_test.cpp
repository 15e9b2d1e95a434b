#include "localization/compass/fields_of_view.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "calib/base/error.hpp"

namespace ceilmap::compass {
namespace {

constexpr double kPi = std::numbers::pi;

double Sum(const std::vector<float>& weights) {
  return std::accumulate(weights.begin(), weights.end(), 0.0);
}

// Eight columns, 45 deg each, the front in column 4, its left in column 2, the back in column 0.
TEST(FieldsOfView, ByHand) {
  const std::vector<float> front_and_back{1, 0, 0, 0, 1, 0, 0, 0};
  EXPECT_EQ(FieldsOfView{}.ColumnWeights(8), front_and_back);
  const std::vector<float> front_and_back_90{1, 1, 0, 1, 1, 1, 0, 1};
  EXPECT_EQ(FieldsOfView::FrontAndBack(0, 90 * kRadPerDeg).ColumnWeights(8), front_and_back_90);
  const FieldsOfView left{.centres_rad = {90 * kRadPerDeg}, .width_rad = 100 * kRadPerDeg};
  const std::vector<float> left_only{0, 1, 1, 1, 0, 0, 0, 0};
  EXPECT_EQ(left.ColumnWeights(8), left_only);
}

TEST(FieldsOfView, EdgesAreInside) {
  const std::vector<float> weights = FieldsOfView{}.ColumnWeights(360);
  for (int u = 0; u < 360; ++u) {
    const bool front = u >= 150 && u <= 210;
    const bool back = u <= 30 || u >= 330;
    EXPECT_EQ(weights[static_cast<std::size_t>(u)], front || back ? 1.0F : 0.0F) << u;
  }
}

TEST(FieldsOfView, FollowTheDirectionOfTravel) {
  const std::vector<float> ahead =
      FieldsOfView::FrontAndBack(0, 40 * kRadPerDeg).ColumnWeights(360);
  // Travel to the left: what counts lies further left in the panorama.
  for (const int degrees : {-400, -90, 17, 90, 179, 361}) {
    std::vector<float> expected(360);
    for (int u = 0; u < 360; ++u) {
      const int from = ((u + degrees) % 360 + 360) % 360;
      expected[static_cast<std::size_t>(u)] = ahead[static_cast<std::size_t>(from)];
    }
    EXPECT_EQ(FieldsOfView::FrontAndBack(degrees * kRadPerDeg, 40 * kRadPerDeg).ColumnWeights(360),
              expected)
        << degrees;
  }
}

TEST(FieldsOfView, TheWholeViewAndFieldsThatOverlapCountOnce) {
  for (const int columns : {8, 45, 360, 1080}) {
    EXPECT_EQ(Sum(FieldsOfView::FrontAndBack(0.3, 2 * kPi).ColumnWeights(columns)), columns);
    EXPECT_EQ(Sum(FieldsOfView::FrontAndBack(1.3, kPi).ColumnWeights(columns)), columns);
  }
  EXPECT_EQ(Sum(FieldsOfView::FrontAndBack(0, 200 * kRadPerDeg).ColumnWeights(360)), 360);
}

// Whatever the direction, a field holds as many columns as fit its width, one more or less.
TEST(FieldsOfView, HoldTheirWidth) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-10, 10);
  std::uniform_real_distribution<double> width(0.1, 3.1);
  for (int i = 0; i < 200; ++i) {
    const auto fields = FieldsOfView::FrontAndBack(angle(random), width(random));
    const int columns = 8 + static_cast<int>(random() % 1000);
    EXPECT_NEAR(
        Sum(fields.ColumnWeights(columns)), 2 * fields.width_rad / (2 * kPi) * columns, 2.001);
  }
}

std::string ErrorOf(const FieldsOfView& fields) {
  try {
    fields.Validate();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(FieldsOfView, RefuseWhatIsNoField) {
  EXPECT_EQ(ErrorOf({}), "no error");
  EXPECT_EQ(ErrorOf({.width_rad = 2 * kPi}), "no error");
  EXPECT_EQ(ErrorOf({.width_rad = 0}), "fields of view: width_rad = 0, must be in (0, 2 pi]");
  EXPECT_EQ(ErrorOf({.width_rad = 7}), "fields of view: width_rad = 7, must be in (0, 2 pi]");
  EXPECT_EQ(ErrorOf({.width_rad = std::nan("")}),
            "fields of view: width_rad = nan, must be in (0, 2 pi]");
  EXPECT_EQ(ErrorOf({.centres_rad = {}}),
            "fields of view: centres_rad is empty, must hold at least one angle");
  EXPECT_EQ(ErrorOf({.centres_rad = {0, std::numeric_limits<double>::infinity()}}),
            "fields of view: centres_rad holds inf, must be finite");
}

}  // namespace
}  // namespace ceilmap::compass
