#include "mapping/places/place_descriptor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "calib/base/error.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::places {
namespace {

using registration::ImageMotion;
using registration::synthetic::SyntheticCeiling;

constexpr double kPi = std::numbers::pi;
const cv::Size kSize(640, 480);

/// Working pixels are two pixels of the first camera.
PlaceDescriptorParams Params() {
  return PlaceDescriptorParams::ForCamera(kSize, 1.0);
}

cv::Mat Describe(const cv::Mat& image, double units_per_px = 1.0) {
  return PlaceDescriber(image.size(), units_per_px, Params()).Describe(image);
}

float VectorDistance(const cv::Mat& a, int i, const cv::Mat& b, int j) {
  return static_cast<float>(
      cv::norm(a.row(i).colRange(2, a.cols), b.row(j).colRange(2, b.cols), cv::NORM_L2));
}

/// How two images' windows correspond under the motion from the first to the second, in units of
/// length about the centres.
struct Correspondence {
  int visible = 0;   ///< windows of the first image well inside the second
  int repeated = 0;  ///< of these: the second has a window there, too
  int nearest = 0;   ///< of these: and its vector is the most similar one of all
};

Correspondence Compare(const cv::Mat& first, const cv::Mat& second, const ImageMotion& motion) {
  constexpr double kSamePlace = 1.0;     // working pixels
  const Eigen::Vector2d reach(125, 85);  // working pixels from the centre
  Correspondence result;
  for (int i = 0; i < first.rows; ++i) {
    const Eigen::Vector2d there =
        motion.Apply({2 * first.at<float>(i, 0), 2 * first.at<float>(i, 1)}) / 2;
    if ((there.cwiseAbs().array() > reach.array()).any()) continue;
    ++result.visible;
    int same = -1;
    int best = 0;
    for (int j = 0; j < second.rows; ++j) {
      const Eigen::Vector2d here(second.at<float>(j, 0), second.at<float>(j, 1));
      if ((here - there).norm() < kSamePlace) same = j;
      if (VectorDistance(first, i, second, j) < VectorDistance(first, i, second, best)) best = j;
    }
    if (same >= 0) ++result.repeated;
    if (same >= 0 && best == same) ++result.nearest;
  }
  return result;
}

void ExpectSame(const Correspondence& found, double repeated, double nearest) {
  EXPECT_GE(found.visible, 8);
  EXPECT_GE(found.repeated, repeated * found.visible);
  EXPECT_GE(found.nearest, nearest * found.repeated);
}

class Ceilings : public ::testing::TestWithParam<double> {
 protected:
  Ceilings() : ceiling_({.seed = 3, .tile_px = GetParam()}) {}
  SyntheticCeiling ceiling_;
};

TEST_P(Ceilings, RotationKeepsPlacesAndVectors) {
  const cv::Mat first = Describe(ceiling_.Render(kSize));
  for (int k = 1; k < 12; ++k) {
    const ImageMotion motion{0, 0, 2 * kPi * k / 12 + 0.01 * k, 1};
    ExpectSame(Compare(first, Describe(ceiling_.Render(kSize, motion)), motion), 0.6, 0.9);
  }
}

TEST_P(Ceilings, ShiftKeepsPlacesAndVectors) {
  const cv::Mat first = Describe(ceiling_.Render(kSize));
  for (const ImageMotion& motion :
       {ImageMotion{91.3, 0.4, 0, 1}, {-150.2, 60.7, 0, 1}, {0.5, -0.5, 0, 1}}) {
    ExpectSame(Compare(first, Describe(ceiling_.Render(kSize, motion)), motion), 0.5, 0.9);
  }
}

TEST_P(Ceilings, NoiseAndLightKeepMost) {
  const cv::Mat first = Describe(ceiling_.Render(kSize));
  const ImageMotion motion{30, -20, 2.0, 1};
  cv::Mat second;
  ceiling_.Render(kSize, motion, 5).convertTo(second, CV_8U, 0.7, 20);
  ExpectSame(Compare(first, Describe(second), motion), 0.5, 0.9);
}

TEST_P(Ceilings, CamerasOfOtherScale) {
  const cv::Mat first = Describe(ceiling_.Render(kSize));
  for (const double magnified : {0.8, 1.25}) {
    const ImageMotion in_pixels{0, 0, -1.2, magnified};
    const cv::Mat second = Describe(ceiling_.Render(kSize, in_pixels), 1 / magnified);
    ExpectSame(Compare(first, second, {0, 0, -1.2, 1}), 0.5, 0.85);
  }
}

INSTANTIATE_TEST_SUITE_P(TilesAndPlaster, Ceilings, ::testing::Values(110.0, 0.0));

TEST(PlaceDescriber, GainAndOffsetChangeNothing) {
  const cv::Mat image = SyntheticCeiling({.lamps = false}).Render(kSize);
  cv::Mat darker;
  image.convertTo(darker, CV_8U, 0.5, 12);
  const Correspondence found = Compare(Describe(image), Describe(darker), {});
  EXPECT_GE(found.nearest, 0.85 * found.visible);
}

TEST(PlaceDescriber, VectorsHaveLengthOneAndWindowsKeepTheirDistance) {
  const cv::Mat rows = Describe(SyntheticCeiling().Render(kSize));
  ASSERT_EQ(rows.type(), CV_32FC1);
  ASSERT_EQ(rows.cols, PlaceDescriber::Dimension());
  ASSERT_EQ(rows.rows, 32) << "the largest number";
  for (int i = 0; i < rows.rows; ++i) {
    EXPECT_NEAR(cv::norm(rows.row(i).colRange(2, rows.cols)), 1, 1e-5);
    for (int j = 0; j < i; ++j) {
      const double apart = cv::norm(rows.row(i).colRange(0, 2), rows.row(j).colRange(0, 2));
      EXPECT_GE(apart, 12 - 1e-3);
    }
  }
}

TEST(PlaceDescriber, SameRowsEveryTime) {
  const SyntheticCeiling ceiling;
  PlaceDescriber describer(kSize, 1.0, Params());
  const cv::Mat first = describer.Describe(ceiling.Render(kSize));
  ASSERT_FALSE(describer.Describe(ceiling.Render(kSize, {50, 0, 1, 1})).empty());
  const cv::Mat again = describer.Describe(ceiling.Render(kSize));
  EXPECT_EQ(cv::norm(first, again, cv::NORM_INF), 0);
}

TEST(PlaceDescriber, BlankImagesGiveNoRows) {
  for (const int grey : {0, 128, 255}) {
    const cv::Mat rows = Describe(cv::Mat(kSize, CV_8UC1, cv::Scalar(grey)));
    EXPECT_EQ(rows.rows, 0);
    EXPECT_EQ(rows.cols, PlaceDescriber::Dimension());
  }
}

TEST(PlaceDescriber, WindowsKeepOutOfTheMask) {
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(255));
  mask.colRange(0, 200) = 0;
  cv::Mat image = SyntheticCeiling().Render(kSize);
  image.colRange(0, 200) = 0;
  const cv::Mat rows = PlaceDescriber(kSize, 1.0, Params(), mask).Describe(image);
  ASSERT_GE(rows.rows, 10);
  double leftmost = 0;
  cv::minMaxLoc(rows.col(0), &leftmost);
  // Column 200 lies 60 working pixels left of the centre; a window has a radius of 24.
  EXPECT_GE(leftmost, -60 + 24);
}

TEST(PlaceDescriber, OddSizesAndScales) {
  for (const cv::Size size : {cv::Size(641, 479), cv::Size(503, 377), cv::Size(333, 501)}) {
    for (const double units : {0.37, 0.5, 0.99, 1.01, 1.7, 2.3}) {
      const cv::Mat image = SyntheticCeiling().Render(size);
      if (std::min(size.width, size.height) * units < 140) continue;
      EXPECT_GT(PlaceDescriber(size, units, Params()).Describe(image).rows, 0)
          << size << " " << units;
    }
  }
}

template <typename Action>
std::string MessageOf(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PlaceDescriber, BadInput) {
  EXPECT_EQ(MessageOf([] {
              PlaceDescriber({640, 0}, 1);
            }),
            "place descriptor: image 640 x 0 of 1 units per pixel, must all be > 0");
  EXPECT_EQ(MessageOf([] { PlaceDescriptorParams::ForCamera(kSize, -2); }),
            "place descriptor: image 640 x 480 of -2 units per pixel, must all be > 0");
  EXPECT_EQ(MessageOf([] { PlaceDescriber(kSize, 0.001, Params()); }),
            "place descriptor: the working image would have 0 x 0 pixels, must be 55 .. 4096 a "
            "side; set PlaceDescriptorParams::units_per_px for these cameras");
  EXPECT_EQ(MessageOf([] { PlaceDescriber(kSize, 1, Params(), cv::Mat::ones(9, 9, CV_8U)); }),
            "place descriptor: the mask must be CV_8UC1 of the image's size");
  EXPECT_EQ(MessageOf([] { (void)Describe(cv::Mat(kSize, CV_8UC3)); }),
            "place descriptor: the image must be CV_8UC1 with 640 x 480 pixels");
  PlaceDescriptorParams params = Params();
  params.units_per_px = 0;
  EXPECT_EQ(MessageOf([&] { PlaceDescriber(kSize, 1, params); }),
            "PlaceDescriptorParams: units_per_px = 0, must be > 0");
}

}  // namespace
}  // namespace ceilmap::places
