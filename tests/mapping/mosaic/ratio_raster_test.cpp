#include "mapping/mosaic/ratio_raster.hpp"

#include <gtest/gtest.h>

#include <atomic>

namespace ceilmap::mosaic {
namespace {

const store::MosaicGrid kRatioGrid{-1.0, 2.0, 0.1, 50, 40};

float Number(int col, int row) {
  return static_cast<float>(1000 * row + col);
}

/// Each pixel's ratio states where it is.
RatioRaster Numbered(const RatioRaster& raster) {
  return raster.Transformed(2, [](const cv::Rect& window, const cv::Mat_<float>& /*ratios*/) {
    cv::Mat_<float> result(window.size());
    for (int row = 0; row < window.height; ++row) {
      for (int col = 0; col < window.width; ++col) {
        result(row, col) = Number(window.x + col, window.y + row);
      }
    }
    return result;
  });
}

TEST(RatioRaster, HasContentAroundAPixelOnly) {
  RatioRaster raster(kRatioGrid);
  EXPECT_TRUE(raster.empty());
  EXPECT_EQ(raster.At(3, 4), 0);
  raster.AddAround(-40, 70);
  EXPECT_FALSE(raster.empty());
  const RatioRaster numbered = Numbered(raster);
  for (const cv::Point& at : {cv::Point(-40, 70), {-72, 70}, {-8, 102}, {-40, 38}}) {
    EXPECT_EQ(numbered.At(at.x, at.y), Number(at.x, at.y)) << at;
  }
  EXPECT_EQ(numbered.At(-40 + 100, 70), 0);
  EXPECT_EQ(numbered.At(-40, -70), 0);
}

TEST(RatioRaster, AWindowHasThePixelsOfAllSquares) {
  RatioRaster raster(kRatioGrid);
  raster.AddAround(0, 0);
  const cv::Rect window(-31, -5, 60, 40);
  const cv::Mat ratios = Numbered(raster).Ratios(window);
  ASSERT_EQ(ratios.size(), window.size());
  for (int row = 0; row < window.height; ++row) {
    for (int col = 0; col < window.width; ++col) {
      ASSERT_EQ(ratios.at<float>(row, col), Number(window.x + col, window.y + row));
    }
  }
}

TEST(RatioRaster, ATransformationLeavesTheOriginal) {
  RatioRaster raster(kRatioGrid);
  raster.AddAround(5, 5);
  const RatioRaster before = Numbered(raster);
  std::atomic<int> pixels = 0;
  const RatioRaster after =
      before.Transformed(0, [&](const cv::Rect& window, const cv::Mat_<float>& ratios) {
        pixels += window.area();
        return cv::Mat_<float>(ratios + 0.5F);
      });
  EXPECT_EQ(pixels, 96 * 96) << "each pixel once";
  EXPECT_EQ(raster.At(7, 9), 0);
  EXPECT_EQ(before.At(7, 9), Number(7, 9));
  EXPECT_EQ(after.At(7, 9), Number(7, 9) + 0.5F);
}

TEST(RatioRaster, AddingAPlaceAgainKeepsItsContent) {
  RatioRaster raster(kRatioGrid);
  raster.AddAround(5, 5);
  raster = Numbered(raster);
  raster.AddAround(40, 5);
  EXPECT_EQ(raster.At(7, 9), Number(7, 9));
  EXPECT_EQ(raster.At(80, 9), 0);
}

TEST(RatioRaster, PlacesAreThoseOfAMosaic) {
  const RatioRaster raster(kRatioGrid);
  const cv::Point2d place = raster.PlaceOf(2, 3);
  EXPECT_NEAR(place.x, -0.75, 1e-12);
  EXPECT_NEAR(place.y, 1.65, 1e-12);
  const cv::Rect2d box = raster.BoxOf({2, 3, 4, 5});
  EXPECT_NEAR(box.x, -0.8, 1e-12);
  EXPECT_NEAR(box.y, 1.2, 1e-12);
  EXPECT_NEAR(box.width, 0.4, 1e-12);
  EXPECT_NEAR(box.height, 0.5, 1e-12);
}

TEST(RatioRaster, TheRangeIsThatOfKnownSurfaces) {
  RatioRaster raster(kRatioGrid);
  EXPECT_EQ(raster.Range(), cv::Vec2f(1, 1));
  raster.AddAround(0, 0);
  EXPECT_EQ(raster.Range(), cv::Vec2f(1, 1));
  raster = raster.Transformed(1, [](const cv::Rect& window, const cv::Mat_<float>& ratios) {
    cv::Mat_<float> result = ratios.clone();
    if (window.contains({0, 0})) {
      result(0, 0) = 1.5F;
      result(0, 1) = 1.2F;
      result(1, 0) = -3;  // refuted
    }
    return result;
  });
  EXPECT_EQ(raster.Range(), cv::Vec2f(1.2F, 1.5F));
}

}  // namespace
}  // namespace ceilmap::mosaic
