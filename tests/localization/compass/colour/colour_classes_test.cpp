#include "localization/compass/colour/colour_classes.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "calib/base/error.hpp"

namespace ceilmap::colour {
namespace {

const std::vector<cv::Vec3b> kColours = {
    {30, 30, 30}, {40, 40, 200}, {60, 180, 60}, {200, 60, 40}, {220, 220, 220}};

/// As many of each, with noise.
cv::Mat Samples(int of_each = 200) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 4);
  cv::Mat samples(1, of_each * static_cast<int>(kColours.size()), CV_8UC3);
  for (int i = 0; i < samples.cols; ++i) {
    const cv::Vec3b& colour = kColours[static_cast<std::size_t>(i) % kColours.size()];
    for (int c = 0; c < 3; ++c) {
      samples.at<cv::Vec3b>(i)[c] =
          cv::saturate_cast<uchar>(static_cast<float>(colour[c]) + noise(random));
    }
  }
  return samples;
}

class Clusterings : public testing::TestWithParam<Clustering> {};

TEST_P(Clusterings, SeparateColours) {
  const ColourClasses classes =
      ColourClasses::Learn(Samples(), {.clustering = GetParam(), .classes = 5});
  std::set<int> found;
  for (const cv::Vec3b& colour : kColours) found.insert(classes.Of(&colour[0]));
  EXPECT_EQ(found.size(), kColours.size());
  for (const ColourClass& one : classes.Classes()) EXPECT_NEAR(one.weight, 0.2, 0.01);
}

TEST_P(Clusterings, AreTheSameForTheSameSamples) {
  const ColourClassParams params{.clustering = GetParam(), .classes = 5};
  const ColourClasses one = ColourClasses::Learn(Samples(), params);
  const ColourClasses two = ColourClasses::Learn(Samples(), params);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(one.Classes()[static_cast<std::size_t>(i)].mean,
              two.Classes()[static_cast<std::size_t>(i)].mean);
  }
  EXPECT_LT(one.Classes().front().mean[0], one.Classes().back().mean[0]) << "by brightness";
}
TEST_P(Clusterings, AnUnknownColourHasNoClass) {
  const ColourClasses classes =
      ColourClasses::Learn(Samples(), {.clustering = GetParam(), .classes = 5});
  const cv::Vec3b cyan{220, 210, 20};
  EXPECT_EQ(classes.Of(&cyan[0]), kNoClass);
  const cv::Vec3b nearly_red{48, 48, 192};
  const cv::Vec3b red = kColours[1];
  EXPECT_EQ(classes.Of(&nearly_red[0]), classes.Of(&red[0]));
  int known = 0;
  const cv::Mat samples = Samples();
  for (int i = 0; i < samples.cols; ++i) known += classes.Of(samples.ptr(0, i)) != kNoClass ? 1 : 0;
  EXPECT_GT(known, 0.97 * samples.cols) << "of those that were learned";
}

INSTANTIATE_TEST_SUITE_P(Both,
                         Clusterings,
                         testing::Values(Clustering::kMeans, Clustering::kMixture));

TEST(ColourClasses, AreTheNearestMeans) {
  // Y, U, V of black and white.
  std::vector<ColourClass> two(2);
  two[0].mean = {0, 128, 128};
  two[1].mean = {255, 128, 128};
  const ColourClasses classes(two);
  const cv::Vec3b dark(100, 100, 100);
  const cv::Vec3b bright(160, 160, 160);
  EXPECT_EQ(classes.Of(&dark[0]), 0);
  EXPECT_EQ(classes.Of(&bright[0]), 1);
}

TEST(ColourClasses, GreyOrDarkImagesHaveNone) {
  cv::Mat grey(1, 1000, CV_8UC3);
  for (int i = 0; i < grey.cols; ++i)
    grey.at<cv::Vec3b>(i) = cv::Vec3b::all(static_cast<uchar>(i % 250));
  EXPECT_THROW(ColourClasses::Learn(grey), InputError);
  EXPECT_THROW(ColourClasses::Learn(cv::Mat(1, 1000, CV_8UC3, cv::Scalar::all(0))), InputError);
}

TEST(ColourClasses, RefuseWhatCannotBe) {
  EXPECT_THROW(ColourClasses(std::vector<ColourClass>(1)), InputError);
  EXPECT_THROW(ColourClasses(std::vector<ColourClass>(33)), InputError);
  ColourClass flat;
  flat.covariance = {};
  EXPECT_THROW(ColourClasses(std::vector<ColourClass>{flat, flat}), InputError);
  EXPECT_THROW(ColourClasses::Learn(Samples(), {.classes = 1}), InputError);
}

}  // namespace
}  // namespace ceilmap::colour
