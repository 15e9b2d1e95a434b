#include "localization/compass/labrosse/column_shift.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "tests/localization/compass/panoramas.hpp"

namespace ceilmap::labrosse {
namespace {

constexpr double kPi = std::numbers::pi;

/// Straight from the definition, pixel by pixel.
std::uint64_t SquaredDistance(const cv::Mat& reference, const cv::Mat& current, int shift) {
  const cv::Mat shifted = compass::Rolled(reference, shift);
  const int channels = current.channels();
  std::uint64_t sum = 0;
  for (int v = 0; v < current.rows; ++v) {
    for (int i = 0; i < current.cols * channels; ++i) {
      const int difference = current.ptr(v)[i] - shifted.ptr(v)[i];
      sum += static_cast<std::uint64_t>(difference * difference);
    }
  }
  return sum;
}

// Eight columns, azimuth falling by 45 deg a column. A lamp stands ahead of the robot, in column 4
// where azimuth is 0. The robot turns left by 90 deg: now the lamp is at its right, azimuth -90,
// two columns further to the right.
TEST(ColumnShift, ALeftTurnMovesTheContentToTheRight) {
  const cv::Mat before = (cv::Mat_<std::uint8_t>(1, 8) << 0, 0, 0, 0, 255, 0, 0, 0);
  const cv::Mat after = (cv::Mat_<std::uint8_t>(1, 8) << 0, 0, 0, 0, 0, 0, 255, 0);
  const auto left = FindColumnShift(before, after);
  ASSERT_TRUE(left.has_value());
  EXPECT_EQ(left->columns, 2);
  EXPECT_NEAR(left->heading_change_rad, kPi / 2, 1e-15);
  EXPECT_EQ(left->distance, 0);
  const auto right = FindColumnShift(after, before);
  ASSERT_TRUE(right.has_value());
  EXPECT_EQ(right->columns, -2);
  EXPECT_NEAR(right->heading_change_rad, -kPi / 2, 1e-15);
}

TEST(ColumnShift, GivesDistancesByHand) {
  const cv::Mat reference = (cv::Mat_<std::uint8_t>(2, 3) << 0, 10, 20, 5, 5, 8);
  const cv::Mat current = (cv::Mat_<std::uint8_t>(2, 3) << 21, 0, 10, 8, 5, 1);
  // Shift 1 leaves 1 and 4 grey levels of difference.
  const std::vector<std::uint64_t> squared{
      441 + 100 + 100 + 9 + 0 + 49, 1 + 16, 121 + 400 + 100 + 9 + 9 + 16};
  EXPECT_EQ(SquaredShiftDistances(reference, current), squared);
  const auto shift = FindColumnShift(reference, current);
  ASSERT_TRUE(shift.has_value());
  EXPECT_EQ(shift->columns, 1);
  EXPECT_DOUBLE_EQ(shift->distance, std::sqrt(17.0));
}

TEST(ColumnShift, FindsEveryShift) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const int width : {2, 45, 90}) {
      const cv::Mat reference = compass::RandomPanorama(5, width, type, 1);
      for (int columns = -(width - 1) / 2; columns <= width / 2; ++columns) {
        const auto shift = FindColumnShift(reference, compass::Rolled(reference, columns));
        ASSERT_TRUE(shift.has_value());
        EXPECT_EQ(shift->columns, columns);
        EXPECT_EQ(shift->distance, 0);
        EXPECT_NEAR(shift->heading_change_rad, 2 * kPi * columns / width, 1e-15);
        EXPECT_GT(shift->heading_change_rad, -kPi);
        EXPECT_LE(shift->heading_change_rad, kPi);
      }
    }
  }
}

TEST(ColumnShift, HalfATurnIsPlusPi) {
  const cv::Mat reference = compass::RandomPanorama(5, 360, CV_8UC3, 2);
  const auto shift = FindColumnShift(reference, compass::Rolled(reference, -180));
  ASSERT_TRUE(shift.has_value());
  EXPECT_EQ(shift->columns, 180);
  EXPECT_EQ(shift->heading_change_rad, kPi);
}

TEST(ColumnShift, FindsAShiftUnderNoiseAndBrightness) {
  const cv::Mat reference = compass::RandomPanorama(45, 360, CV_8UC3, 3);
  cv::Mat current =
      0.7 * compass::Rolled(reference, -17) + 0.2 * compass::RandomPanorama(45, 360, CV_8UC3, 4);
  const auto shift = FindColumnShift(reference, current);
  ASSERT_TRUE(shift.has_value());
  EXPECT_EQ(shift->columns, -17);
}

TEST(ColumnShift, AgreesWithTheDefinition) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const int width : {2, 3, 17, 64}) {
      const cv::Mat reference = compass::RandomPanorama(7, width, type, 5);
      const cv::Mat current = compass::RandomPanorama(7, width, type, 6);
      const auto squared = SquaredShiftDistances(reference, current);
      ASSERT_EQ(squared.size(), static_cast<std::size_t>(width));
      for (int shift = 0; shift < width; ++shift) {
        EXPECT_EQ(squared[static_cast<std::size_t>(shift)],
                  SquaredDistance(reference, current, shift));
      }
    }
  }
}

TEST(ColumnShift, TakesPartsOfLargerImages) {
  const cv::Mat large = compass::RandomPanorama(20, 50, CV_8UC3, 7);
  const cv::Mat reference = large(cv::Rect(3, 2, 30, 9));
  const cv::Mat current = large(cv::Rect(11, 8, 30, 9));
  EXPECT_EQ(SquaredShiftDistances(reference, current),
            SquaredShiftDistances(reference.clone(), current.clone()));
}

// Black against white over many rows: the sums pass 32 bits.
TEST(ColumnShift, SumsDoNotOverflow) {
  const cv::Mat black(700, 40, CV_8UC3, cv::Scalar::all(0));
  const cv::Mat white(700, 40, CV_8UC3, cv::Scalar::all(255));
  for (const std::uint64_t squared : SquaredShiftDistances(black, white)) {
    EXPECT_EQ(squared, std::uint64_t{700} * 40 * 3 * 255 * 255);
  }
}

TEST(ColumnShift, HasNoAnswerOnUniformPanoramas) {
  const cv::Mat grey(5, 36, CV_8UC3, cv::Scalar(10, 20, 30));
  EXPECT_FALSE(FindColumnShift(grey, grey).has_value());
  EXPECT_FALSE(FindColumnShift(grey, compass::RandomPanorama(5, 36, CV_8UC3, 8)).has_value());
  const cv::Mat two_columns(5, 2, CV_8UC1, cv::Scalar(7));
  EXPECT_FALSE(FindColumnShift(two_columns, two_columns).has_value());
}

// A room that is identical after half or a quarter of a turn.
TEST(ColumnShift, HasNoAnswerOnPeriodicPanoramas) {
  for (const int repeats : {2, 4}) {
    const cv::Mat once = compass::RandomPanorama(5, 12, CV_8UC1, 9);
    const cv::Mat reference = cv::repeat(once, 1, repeats);
    EXPECT_FALSE(FindColumnShift(reference, compass::Rolled(reference, 3)).has_value());
  }
}

// The mean of the unmoved panorama and the one moved by a column is equally far from both.
TEST(ColumnShift, TakesTheSmallerOfTwoNeighbours) {
  cv::Mat reference;
  compass::RandomPanorama(5, 36, CV_8UC1, 10).convertTo(reference, CV_8U, 0.5);
  reference *= 2;  // even, so that the means below are exact
  for (const int columns : {-18, -5, -1, 0, 4, 17}) {
    const cv::Mat current =
        0.5 * compass::Rolled(reference, columns) + 0.5 * compass::Rolled(reference, columns + 1);
    const auto shift = FindColumnShift(reference, current);
    ASSERT_TRUE(shift.has_value()) << columns;
    EXPECT_EQ(shift->columns, columns < 0 ? columns + 1 : columns);
    EXPECT_GT(shift->distance, 0);
  }
}

std::string ErrorOf(const cv::Mat& reference, const cv::Mat& current) {
  try {
    (void)FindColumnShift(reference, current);
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError";
  return {};
}

TEST(ColumnShift, RefusesUnusablePanoramas) {
  const cv::Mat good(45, 360, CV_8UC3, cv::Scalar::all(0));
  const std::string range =
      " pixels, must have 2 to 16384 columns and at least 1 row; unwrap it with other settings";
  EXPECT_EQ(ErrorOf({}, good), "reference panorama is 0 x 0" + range);
  EXPECT_EQ(ErrorOf(good, {}), "current panorama is 0 x 0" + range);
  EXPECT_EQ(ErrorOf(cv::Mat(45, 1, CV_8UC3), good), "reference panorama is 1 x 45" + range);
  EXPECT_EQ(ErrorOf(good, cv::Mat(1, 16385, CV_8UC3)), "current panorama is 16385 x 1" + range);
  for (const int type : {CV_8UC4, CV_8SC1, CV_32FC3}) {
    EXPECT_EQ(ErrorOf(good, cv::Mat(45, 360, type)),
              "current panorama is " + cv::typeToString(type) +
                  ", must be CV_8UC1 or CV_8UC3; convert it");
  }
}

TEST(ColumnShift, RefusesPanoramasThatDiffer) {
  const cv::Mat reference(45, 360, CV_8UC3, cv::Scalar::all(0));
  const std::string end = ", must be equal; unwrap both with the same settings";
  EXPECT_EQ(ErrorOf(reference, cv::Mat(45, 361, CV_8UC3)),
            "panoramas differ: reference 360 x 45 CV_8UC3, current 361 x 45 CV_8UC3" + end);
  EXPECT_EQ(ErrorOf(reference, cv::Mat(44, 360, CV_8UC3)),
            "panoramas differ: reference 360 x 45 CV_8UC3, current 360 x 44 CV_8UC3" + end);
  EXPECT_EQ(ErrorOf(reference, cv::Mat(45, 360, CV_8UC1)),
            "panoramas differ: reference 360 x 45 CV_8UC3, current 360 x 45 CV_8UC1" + end);
  EXPECT_THROW((void)SquaredShiftDistances(reference, cv::Mat(45, 361, CV_8UC3)), InputError);
}

}  // namespace
}  // namespace ceilmap::labrosse
