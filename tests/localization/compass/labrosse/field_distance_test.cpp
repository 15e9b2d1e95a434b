#include "localization/compass/labrosse/field_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "calib/base/error.hpp"
#include "localization/compass/labrosse/column_shift.hpp"
#include "tests/localization/compass/panoramas.hpp"

namespace ceilmap::labrosse {
namespace {

TEST(FieldDistance, OfTheWholeViewIsThatOfAllShifts) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat reference = compass::RandomPanorama(6, 33, type, 1);
    const cv::Mat current = compass::RandomPanorama(6, 33, type, 2);
    const std::vector<std::uint64_t> expected = SquaredShiftDistances(reference, current);
    const FieldDistance distance(reference, current, std::vector<float>(33, 1));
    for (int shift = -40; shift < 80; ++shift) {
      EXPECT_EQ(distance.Squared(shift), expected[static_cast<std::size_t>((shift + 66) % 33)]);
    }
  }
}

TEST(FieldDistance, CountsTheCurrentPanoramasColumnsInside) {
  std::mt19937 random(3);
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (int trial = 0; trial < 20; ++trial) {
      const cv::Mat reference = compass::RandomPanorama(4, 25, type, random());
      const cv::Mat current = compass::RandomPanorama(4, 25, type, random());
      std::vector<float> weights(25);
      for (float& weight : weights) weight = random() % 3 == 0 ? 0.0F : 1.0F;
      const FieldDistance distance(reference, current, weights);
      for (int shift = -12; shift <= 12; ++shift) {
        const cv::Mat shifted = compass::Rolled(reference, shift);
        double expected = 0;
        for (int u = 0; u < 25; ++u) {
          if (weights[static_cast<std::size_t>(u)] == 0) continue;
          expected += cv::norm(current.col(u), shifted.col(u), cv::NORM_L2SQR);
        }
        EXPECT_EQ(static_cast<double>(distance.Squared(shift)), expected);
      }
    }
  }
}

TEST(FieldDistance, RefusesPanoramasThatDiffer) {
  EXPECT_THROW(FieldDistance(compass::RandomPanorama(4, 25, CV_8UC1, 1),
                             compass::RandomPanorama(4, 25, CV_8UC3, 1),
                             std::vector<float>(25, 1)),
               InputError);
}

TEST(RowTexture, ByHand) {
  const cv::Mat panorama = (cv::Mat_<std::uint8_t>(2, 4) << 10, 14, 99, 99, 50, 50, 99, 0);
  // Deviations -2, 2 and 0, 0.
  EXPECT_DOUBLE_EQ(RowTexture(panorama, std::vector<float>{1, 1, 0, 0}), std::sqrt(8.0 / 4));
  EXPECT_EQ(RowTexture(panorama, std::vector<float>{0, 0, 0, 0}), 0);
}

// Rows of different grey, and channels of different grey, are no texture.
TEST(RowTexture, IsAlongTheRowsOfEachChannel) {
  cv::Mat panorama(3, 20, CV_8UC3);
  for (int v = 0; v < 3; ++v) panorama.row(v).setTo(cv::Scalar(10 + 60 * v, 90, 200 - 30 * v));
  EXPECT_NEAR(RowTexture(panorama, std::vector<float>(20, 1)), 0, 1e-6);
}

}  // namespace
}  // namespace ceilmap::labrosse
