#include "mapping/mosaic/view_agreement.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "mapping/mosaic/levelling.hpp"
#include "tests/mapping/mosaic/two_planes.hpp"

namespace ceilmap::mosaic {
namespace {

const cv::Size kCeilingSize(160, 120);
constexpr double kCeilingUnitsPerPx = 0.01;

/// Views from one place, whose images are plain: of one grey value, and of another one in a patch.
class PlainViews {
 public:
  void Add(int grey) { Add(cv::Mat(kCeilingSize, CV_8UC1, cv::Scalar(grey))); }
  void Add(const cv::Mat& image) {
    views.emplace_back(Pose2(), kCeilingSize, kCeilingUnitsPerPx);
    thumbnails.Add(image);
    candidates.push_back(static_cast<int>(candidates.size()));
  }
  void AddAll(const std::vector<int>& greys) {
    for (const int grey : greys) Add(grey);
  }

  /// Factor of each view at the centre of the images.
  [[nodiscard]] std::vector<float> Factors() const {
    const std::vector<Agreement> agreements = Compare(HeightMap());
    std::vector<float> factors;
    factors.reserve(agreements.size());
    for (const Agreement& agreement : agreements) {
      factors.push_back(agreement.IsFull() ? 1 : agreement.At(80, 60));
    }
    return factors;
  }
  [[nodiscard]] std::vector<Agreement> Compare(const HeightMap& heights) const {
    return CompareViews({0, 0, 160, 120}, kGrid, views, candidates, thumbnails, heights);
  }

  static inline const store::MosaicGrid kGrid{-0.8, 0.6, kCeilingUnitsPerPx, 160, 120};
  std::vector<ViewPlacement> views;
  std::vector<int> candidates;
  Thumbnails thumbnails{kCeilingSize};
};

TEST(ViewAgreement, IsFullWhereAllShowTheSame) {
  PlainViews plain;
  plain.AddAll({120, 121, 119, 122});
  for (const Agreement& agreement : plain.Compare(HeightMap())) EXPECT_TRUE(agreement.IsFull());
}

TEST(ViewAgreement, AnOutlierOfThreeHasNearlyNoWeight) {
  PlainViews plain;
  plain.AddAll({120, 60, 121});
  const std::vector<float> factors = plain.Factors();
  EXPECT_EQ(factors[0], 1);
  EXPECT_EQ(factors[2], 1);
  EXPECT_LT(factors[1], 1e-6F);
  EXPECT_GT(factors[1], 0) << "where no other view sees the ceiling, it still counts";
}

TEST(ViewAgreement, TwoViewsDoNotTellWhichIsWrong) {
  PlainViews plain;
  plain.AddAll({120, 60});
  for (const float factor : plain.Factors()) EXPECT_EQ(factor, 1);
}

TEST(ViewAgreement, DifferencesAreRelative) {
  PlainViews bright;
  bright.AddAll({200, 200, 215});  // 7.5 %
  EXPECT_EQ(bright.Factors()[2], 1);
  PlainViews middle;
  middle.AddAll({100, 100, 115});  // half way from 10 to 20 %
  EXPECT_NEAR(middle.Factors()[2], 0.5, 0.01);
  PlainViews dark;
  dark.AddAll({5, 5, 8});  // noise
  EXPECT_EQ(dark.Factors()[2], 1);
}

/// Blades of a fan are in five of nine images, each in another light.
TEST(ViewAgreement, WhatAThirdShowsAlikeIsThereWhereMostDiffer) {
  PlainViews plain;
  plain.AddAll({10, 30, 50, 70, 90, 120, 120, 121, 121});
  const std::vector<float> factors = plain.Factors();
  for (std::size_t k = 0; k < 5; ++k) EXPECT_LT(factors[k], 1e-6F) << k;
  for (std::size_t k = 5; k < 9; ++k) EXPECT_EQ(factors[k], 1) << k;
}

TEST(ViewAgreement, WhereMostAgreeTheMedianIsThere) {
  PlainViews plain;
  plain.AddAll({96, 96, 98, 100, 102, 105, 108, 140, 140, 140, 140});
  const std::vector<float> factors = plain.Factors();
  for (std::size_t k = 0; k < 7; ++k) EXPECT_EQ(factors[k], 1) << k;
  for (std::size_t k = 7; k < 11; ++k) EXPECT_LT(factors[k], 1e-6F) << k;
}

/// In one of four images something covers the right half.
TEST(ViewAgreement, EndsSmoothlyAroundAnOutlier) {
  PlainViews plain;
  plain.AddAll({120, 120, 120});
  cv::Mat covered(kCeilingSize, CV_8UC1, cv::Scalar(120));
  covered.colRange(80, 160).setTo(40);
  plain.Add(covered);
  const std::vector<Agreement> agreements = plain.Compare(HeightMap());
  for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(agreements[k].IsFull());
  const Agreement& last = agreements.back();
  ASSERT_FALSE(last.IsFull());
  // Cells of 8 pixels; those beside an outlier are excluded too.
  EXPECT_LT(last.At(76, 60), 1e-6F);
  EXPECT_EQ(last.At(20, 60), 1);
  EXPECT_NEAR(last.At(71, 60), 0.5, 0.1);
  float before = 1;
  float largest_step = 0;
  for (int col = 20; col < 76; ++col) {
    const float here = last.At(col, 60);
    EXPECT_LE(here, before + 1e-6F);
    largest_step = std::max(largest_step, before - here);
    before = here;
  }
  EXPECT_LT(largest_step, 0.13F);
}

TEST(ViewAgreement, PartOfTheViewsThatAgree) {
  PlainViews plain;
  plain.AddAll({120, 60});
  EXPECT_EQ(AgreementAt({0, 0}, 1, plain.views, plain.candidates, plain.thumbnails), 1);
  plain.AddAll({121, 119, 60});
  EXPECT_NEAR(AgreementAt({0, 0}, 1, plain.views, plain.candidates, plain.thumbnails), 0.6, 1e-6);
  EXPECT_EQ(AgreementAt({5, 0}, 1, plain.views, plain.candidates, plain.thumbnails), 1)
      << "no view shows the place";
}

TEST(ViewAgreement, ImagesAgreeAtTheRatioOfTheSurface) {
  constexpr double kYaw = -1.5707963;  // the images lie along x
  const two_planes::Drive drive(
      {{-0.31, 0, kYaw}, {0.3, 0.1, kYaw}, {0.5, -0.1, kYaw}, {0.7, 0, kYaw}});
  Thumbnails thumbnails(two_planes::kViewSize);
  for (std::size_t k = 0; k < drive.views.size(); ++k) {
    // Only the plate is bright.
    cv::Mat image(two_planes::kViewSize, CV_8UC1);
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const bool plate = two_planes::RhoAt(drive.views[k], cv::Point2d(u, v)) > 1;
        image.at<unsigned char>(v, u) = plate ? 200 : 50;
      }
    }
    thumbnails.Add(image);
  }
  // 0.11 from the plate's left border; on the reference plane the first view shows deck there.
  const cv::Point2d place(0.31, 0);
  const std::vector<int> all{0, 1, 2, 3};
  EXPECT_EQ(AgreementAt(place, two_planes::kPlateRho, drive.views, all, thumbnails), 1);
  EXPECT_EQ(AgreementAt(place, 1, drive.views, all, thumbnails), 0.75);

  const HeightMap heights(drive.keyframes, drive.metadata);
  const store::MosaicGrid grid{0.2, 0.05, 0.0025, 80, 40};
  for (const Agreement& agreement :
       CompareViews({44, 20, 1, 1}, grid, drive.views, all, thumbnails, heights)) {
    EXPECT_TRUE(agreement.IsFull() || agreement.At(44, 20) == 1);
  }
}

TEST(Thumbnails, AreLevelled) {
  Thumbnails thumbnails(kCeilingSize);
  thumbnails.Add(cv::Mat(kCeilingSize, CV_8UC1, cv::Scalar(100)));
  thumbnails.Add(cv::Mat(kCeilingSize, CV_8UC1, cv::Scalar(50)));
  ExposureModel exposure;
  exposure.vignetting = {-0.5, 0, 0};
  thumbnails.Level({1, 2}, MakeShading(kCeilingSize, {}, 1, exposure));
  for (const int k : {0, 1}) {
    EXPECT_NEAR(thumbnails.At(k, {79.5, 59.5}), 100, 2) << k;
    const double corner = 100 * std::exp(0.5);  // about: the thumbnail's corner is inside
    EXPECT_NEAR(thumbnails.At(k, {0, 0}), corner, 0.12 * corner) << k;
  }
}

TEST(Thumbnails, AreInterpolatedAndEndWithTheImage) {
  Thumbnails thumbnails(kCeilingSize);
  cv::Mat ramp(kCeilingSize, CV_8UC1);
  for (int u = 0; u < kCeilingSize.width; ++u) ramp.col(u).setTo(40 + u);
  thumbnails.Add(ramp);
  for (const double u : {10.0, 33.3, 80.0, 150.0}) {
    EXPECT_NEAR(thumbnails.At(0, {u, 60}), 40 + u, 1) << u;
  }
  EXPECT_GE(thumbnails.At(0, {0, 0}), 0);
  EXPECT_GE(thumbnails.At(0, {159, 119}), 0);
  for (const cv::Point2d& outside : {cv::Point2d(-0.1, 60), {159.1, 60}, {80, -1}, {80, 120}}) {
    EXPECT_LT(thumbnails.At(0, outside), 0) << outside;
  }
}

}  // namespace
}  // namespace ceilmap::mosaic
