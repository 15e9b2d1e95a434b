#include "calib/remap_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ceilmap::calib {
namespace {

cv::Mat RandomImage(cv::Size size) {
  cv::Mat image(size, CV_8UC1);
  std::mt19937 random(4);
  for (auto& pixel : cv::Mat_<std::uint8_t>(image)) {
    pixel = static_cast<std::uint8_t>(random() & 255U);
  }
  return image;
}

TEST(RemapTable, IdentityIsExact) {
  const cv::Mat raw = RandomImage({37, 23});
  const RemapTable table(raw.size(), [](int u, int v) { return cv::Point2d(u, v); });
  cv::Mat result;
  table.Apply(raw, result);
  EXPECT_EQ(cv::norm(raw, result, cv::NORM_INF), 0);
  EXPECT_EQ(cv::countNonZero(table.Mask()), raw.size().area());
}

TEST(RemapTable, InterpolatesByHand) {
  const cv::Mat raw = (cv::Mat_<std::uint8_t>(2, 2) << 0, 100, 200, 40);
  const RemapTable table(
      {2, 2}, [](int u, int v) { return cv::Point2d(0.25 + 0.5 * u, v == 0 ? 0.0 : 0.5); });
  cv::Mat result;
  table.Apply(raw, result);
  EXPECT_EQ(result.at<std::uint8_t>(0, 0), 25);
  EXPECT_EQ(result.at<std::uint8_t>(0, 1), 75);
  EXPECT_EQ(result.at<std::uint8_t>(1, 0), 93);  // (25 + 160) / 2 = 92.5, rounded up
  EXPECT_EQ(result.at<std::uint8_t>(1, 1), 78);  // (75 + 80) / 2 = 77.5
}

TEST(RemapTable, ShiftsItsSources) {
  const cv::Size size(70, 37);
  const cv::Mat raw = RandomImage(size);
  const auto source = [](int u, int v) { return cv::Point2d(0.9 * u + 1.25, 0.8 * v + 2.5); };
  // Linear in the pixel, so that the grid gives it exactly.
  const auto shift_at = [](int u, int v) {
    return cv::Point2d(0.25 - u / 64.0, 0.5 + v / 32.0 - u / 128.0);
  };
  SourceShift shift;
  shift.nodes.create(SourceShift::NodesFor(size));
  for (int i = 0; i < shift.nodes.rows; ++i) {
    for (int j = 0; j < shift.nodes.cols; ++j) {
      const cv::Point2d at = shift_at(SourceShift::kSpacingPx * j, SourceShift::kSpacingPx * i);
      shift.nodes(i, j) = {static_cast<float>(at.x), static_cast<float>(at.y)};
    }
  }
  cv::Mat expected;
  RemapTable(size, [&](int u, int v) {
    return source(u, v) + shift_at(u, v);
  }).Apply(raw, expected);
  cv::Mat result;
  RemapTable(size, source).Apply(raw, shift, result);
  EXPECT_LE(cv::norm(expected, result, cv::NORM_INF), 1);  // positions are rounded twice
  shift.nodes.setTo(cv::Scalar::all(0));
  RemapTable(size, source).Apply(raw, shift, result);
  RemapTable(size, source).Apply(raw, expected);
  EXPECT_EQ(cv::norm(expected, result, cv::NORM_INF), 0);
}

TEST(RemapTable, ShiftedSourcesEndAtTheBorder) {
  const cv::Mat raw = (cv::Mat_<std::uint8_t>(2, 2) << 10, 20, 30, 40);
  const RemapTable table({2, 2}, [](int u, int v) { return cv::Point2d(u, v); });
  SourceShift shift;
  shift.nodes.create(SourceShift::NodesFor({2, 2}));
  cv::Mat result;
  shift.nodes.setTo(cv::Scalar(5, -5));
  table.Apply(raw, shift, result);
  EXPECT_EQ(cv::countNonZero(result != 20), 0);
  shift.nodes.setTo(cv::Scalar(-5, 5));
  table.Apply(raw, shift, result);
  EXPECT_EQ(cv::countNonZero(result != 30), 0);
}

TEST(RemapTable, IsZeroAndMaskedWhereThereIsNoSource) {
  const cv::Mat raw(10, 10, CV_8UC1, cv::Scalar(77));
  const RemapTable table({10, 10}, [](int u, int v) -> std::optional<cv::Point2d> {
    if (v == 9) return std::nullopt;
    return cv::Point2d(u + 0.5, v);  // the last column lies outside
  });
  cv::Mat result;
  table.Apply(raw, result);
  const cv::Mat mask = table.Mask();
  for (int v = 0; v < 10; ++v) {
    for (int u = 0; u < 10; ++u) {
      const bool inside = u < 9 && v < 9;
      EXPECT_EQ(mask.at<std::uint8_t>(v, u), inside ? 255 : 0);
      EXPECT_EQ(result.at<std::uint8_t>(v, u), inside ? 77 : 0);
    }
  }
}

// A steep ramp shows the position that was sampled: 1/100 px is one grey level here. The fixed 1/32
// px of cv::remap would be off by up to 1.6 levels.
TEST(RemapTable, SamplesFinelyBetweenPixels) {
  const cv::Mat raw = (cv::Mat_<std::uint8_t>(2, 2) << 50, 150, 50, 150);
  for (int hundredths = 0; hundredths <= 100; ++hundredths) {
    const RemapTable table({2, 2}, [&](int, int) { return cv::Point2d(0.01 * hundredths, 0.3); });
    cv::Mat result;
    table.Apply(raw, result);
    EXPECT_EQ(result.at<std::uint8_t>(0, 0), 50 + hundredths);
  }
}

TEST(RemapTable, TreatsEachColourAsAImageOfItsOwn) {
  const cv::Size size(31, 17);
  const RemapTable table(size, {40, 9}, [](int u, int v) {
    return cv::Point2d(0.7 * u + 0.2, 1.5 * v + 0.4);  // past the image's right border too
  });
  const cv::Mat blue = RandomImage(size);
  cv::Mat green;
  cv::flip(blue, green, 0);
  cv::Mat red;
  cv::flip(blue, red, 1);
  cv::Mat colour;
  cv::merge(std::vector<cv::Mat>{blue, green, red}, colour);
  cv::Mat result;
  table.Apply(colour, result);
  ASSERT_EQ(result.size(), cv::Size(40, 9));
  ASSERT_EQ(table.Mask().size(), cv::Size(40, 9));
  std::vector<cv::Mat> channels;
  cv::split(result, channels);
  const cv::Mat* const raw[] = {&blue, &green, &red};
  for (std::size_t c = 0; c < 3; ++c) {
    cv::Mat alone;
    table.Apply(*raw[c], alone);
    EXPECT_EQ(cv::norm(alone, channels[c], cv::NORM_INF), 0);
  }
}

TEST(RemapTable, TakesAPartOfALargerImage) {
  const cv::Mat large = RandomImage({60, 50});
  const cv::Mat part = large(cv::Rect(7, 5, 30, 20));
  const RemapTable table(part.size(),
                         [](int u, int v) { return cv::Point2d(0.9 * u + 0.3, 0.9 * v + 0.7); });
  cv::Mat of_ratio;
  cv::Mat of_copy;
  table.Apply(part, of_ratio);
  table.Apply(part.clone(), of_copy);
  EXPECT_EQ(cv::norm(of_ratio, of_copy, cv::NORM_INF), 0);
}

}  // namespace
}  // namespace ceilmap::calib
