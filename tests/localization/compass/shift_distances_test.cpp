#include "localization/compass/shift_distances.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "calib/base/error.hpp"
#include "localization/compass/labrosse/column_shift.hpp"

namespace ceilmap::compass {
namespace {

using Means = ShiftDistances::Means;

/// By the definition, in double.
std::vector<double> BruteForce(const cv::Mat& reference,
                               const cv::Mat& current,
                               const std::vector<float>& weights,
                               Means means) {
  const int columns = current.cols;
  const int channels = current.channels();
  std::vector<double> squared(static_cast<std::size_t>(columns), 0.0);
  for (int v = 0; v < current.rows; ++v) {
    for (int c = 0; c < channels; ++c) {
      const auto value = [&](const cv::Mat& panorama, int u) {
        return static_cast<double>(panorama.ptr(v)[u * channels + c]);
      };
      double off = 0;
      for (int u = 0; u < columns; ++u) off += value(current, u) - value(reference, u);
      off = means == Means::kIgnore ? off / columns : 0;
      for (int s = 0; s < columns; ++s) {
        for (int u = 0; u < columns; ++u) {
          const double d = value(current, u) - value(reference, (u - s + columns) % columns) - off;
          const double weight = weights.empty() ? 1 : weights[static_cast<std::size_t>(u)];
          squared[static_cast<std::size_t>(s)] += weight * d * d;
        }
      }
    }
  }
  return squared;
}

std::vector<double> ByFft(const cv::Mat& reference,
                          const cv::Mat& current,
                          const std::vector<float>& weights,
                          Means means) {
  ShiftDistances distances(current.size(), current.channels());
  PanoramaSpectrum a;
  PanoramaSpectrum b;
  distances.Analyze(reference, a);
  distances.Analyze(current, b);
  std::vector<double> squared(static_cast<std::size_t>(current.cols));
  distances.Squared(a, b, weights, means, squared);
  return squared;
}

/// The distances themselves and not their squares are what the papers compare; the bound holds for
/// the squares, too.
void ExpectSame(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t s = 0; s < found.size(); ++s) {
    EXPECT_GE(found[s], 0) << s;
    EXPECT_NEAR(found[s], expected[s], 1e-4 * expected[s] + 1e-3) << s;
  }
}

cv::Mat Random(std::mt19937& random, int columns, int rows, int type) {
  cv::Mat panorama(rows, columns, type);
  cv::RNG fill(random());
  fill.fill(panorama, cv::RNG::UNIFORM, 0, 256);
  return panorama;
}

cv::Mat Shifted(const cv::Mat& panorama, int columns) {
  cv::Mat shifted(panorama.size(), panorama.type());
  for (int u = 0; u < panorama.cols; ++u) {
    panorama.col(u).copyTo(shifted.col((u + columns) % panorama.cols));
  }
  return shifted;
}

std::vector<float> RandomWeights(std::mt19937& random, int columns) {
  std::vector<float> weights(static_cast<std::size_t>(columns));
  std::uniform_real_distribution<float> value(0, 1);
  for (float& weight : weights) weight = value(random) < 0.5F ? 0.F : value(random);
  weights[0] = 1;
  return weights;
}

TEST(ShiftDistances, AreThoseOfBruteForceForEveryShift) {
  std::mt19937 random(1);
  for (int round = 0; round < 40; ++round) {
    const int columns = std::uniform_int_distribution(8, 190)(random);
    const int rows = std::uniform_int_distribution(1, 12)(random);
    const int type = round % 3 == 0 ? CV_8UC1 : CV_8UC3;
    const cv::Mat reference = Random(random, columns, rows, type);
    const cv::Mat current = Random(random, columns, rows, type);
    const std::vector<float> weights =
        round % 2 == 0 ? std::vector<float>{} : RandomWeights(random, columns);
    for (const Means means : {Means::kCompare, Means::kIgnore}) {
      SCOPED_TRACE(testing::Message() << columns << " x " << rows << " round " << round);
      ExpectSame(ByFft(reference, current, weights, means),
                 BruteForce(reference, current, weights, means));
    }
  }
}

/// Where the panoramas agree hardly anything of large numbers is left.
TEST(ShiftDistances, AreExactWhereThePanoramasAgree) {
  std::mt19937 random(2);
  for (int round = 0; round < 12; ++round) {
    const cv::Mat reference = Random(random, 180, 9, CV_8UC3);
    cv::Mat current = Shifted(reference, 17 * round);
    cv::Mat noise(current.size(), current.type());
    cv::RNG(random()).fill(noise, cv::RNG::UNIFORM, 0, 2);
    if (round % 3 != 0) current += noise;
    const std::vector<float> weights =
        round % 2 == 0 ? std::vector<float>{} : RandomWeights(random, 180);
    const auto found = ByFft(reference, current, weights, Means::kCompare);
    const auto expected = BruteForce(reference, current, weights, Means::kCompare);
    SCOPED_TRACE(round);
    ExpectSame(found, expected);
    const auto least = std::min_element(found.begin(), found.end()) - found.begin();
    EXPECT_EQ(least, (17 * round) % 180);
    if (round % 3 == 0) {
      EXPECT_EQ(found[static_cast<std::size_t>(least)], 0);
    }
  }
}

TEST(ShiftDistances, HaveTheMinimumOfTheExactIntegers) {
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    const cv::Mat reference = Random(random, 360, 5, CV_8UC3);
    const cv::Mat current = Random(random, 360, 5, CV_8UC3);
    const auto exact = labrosse::SquaredShiftDistances(reference, current);
    const auto found = ByFft(reference, current, {}, Means::kCompare);
    EXPECT_EQ(std::min_element(found.begin(), found.end()) - found.begin(),
              std::min_element(exact.begin(), exact.end()) - exact.begin());
  }
}

TEST(ShiftDistances, OfUniformPanoramasAreThatOfTheirGreyLevels) {
  const cv::Mat dark(4, 90, CV_8UC1, cv::Scalar(10));
  const cv::Mat light(4, 90, CV_8UC1, cv::Scalar(250));
  for (const double value : ByFft(dark, light, {}, Means::kCompare)) {
    EXPECT_NEAR(value, 4 * 90 * 240.0 * 240.0, 1);
  }
  for (const double value : ByFft(dark, light, {}, Means::kIgnore)) EXPECT_EQ(value, 0);
}

TEST(ShiftDistances, RefuseOtherPanoramas) {
  ShiftDistances distances({90, 4}, 3);
  PanoramaSpectrum spectrum;
  EXPECT_THROW(distances.Analyze(cv::Mat(4, 91, CV_8UC3), spectrum), InputError);
  EXPECT_THROW(distances.Analyze(cv::Mat(4, 90, CV_8UC1), spectrum), InputError);
  EXPECT_THROW(ShiftDistances({90, 4}, 2), InputError);
}

}  // namespace
}  // namespace ceilmap::compass
