#include <gtest/gtest.h>

#include <cmath>

#include "mapping/mosaic/mosaic.hpp"
#include "tests/mapping/mosaic/two_planes.hpp"

namespace ceilmap::mosaic {
namespace {

using two_planes::Drive;
using two_planes::kPlate;

MosaicParams Unlevelled() {
  MosaicParams params;
  params.level_exposure = false;
  return params;
}

/// A mosaic compared with the ceiling seen from straight below.
struct Orthophoto {
  store::MosaicGrid grid;
  cv::Mat grey;
  cv::Mat alpha;

  explicit Orthophoto(const MosaicRenderer& renderer) : grid(renderer.Grid()) {
    renderer.Render({0, 0, grid.width_px, grid.height_px}, grey, alpha);
  }
  /// Root mean square of the difference inside of an area. @param dx  moves the truth.
  [[nodiscard]] double Rms(const cv::Rect2d& area, double dx = 0) const {
    double sum = 0;
    int count = 0;
    for (int row = 0; row < grid.height_px; ++row) {
      for (int col = 0; col < grid.width_px; ++col) {
        const double x = grid.min_x + (col + 0.5) * grid.resolution;
        const double y = grid.max_y - (row + 0.5) * grid.resolution;
        if (!area.contains({x, y})) continue;
        EXPECT_EQ(alpha.at<unsigned char>(row, col), 255) << x << ' ' << y;
        const double error = grey.at<unsigned char>(row, col) - two_planes::Truth(x + dx, y);
        sum += error * error;
        ++count;
      }
    }
    return std::sqrt(sum / count);
  }
};

/// The plate and the deck beside it, without the border between them.
const cv::Rect2d kOnPlate(kPlate.x + 0.06,
                          kPlate.y + 0.06,
                          kPlate.width - 0.12,
                          kPlate.height - 0.12);
const cv::Rect2d kBeside(-0.5, -0.5, 0.64, 1.0);
const cv::Rect2d kBehind(0.96, -0.3, 0.1, 0.6);

TEST(MosaicHeights, EachSurfaceIsShownAtItsPlace) {
  const Drive drive = two_planes::Rows();
  const Orthophoto mosaic(
      MosaicRenderer(drive.keyframes, drive.metadata, drive.Loader(), Unlevelled()));
  for (const cv::Rect2d& area : {kOnPlate, kBeside, kBehind}) {
    const double rms = mosaic.Rms(area);
    EXPECT_LT(rms, 2) << area;
    EXPECT_GT(mosaic.Rms(area, 0.3 * two_planes::kUnitsPerPx), rms) << area;
    EXPECT_GT(mosaic.Rms(area, -0.3 * two_planes::kUnitsPerPx), rms) << area;
  }
}

TEST(MosaicHeights, WithoutHeightsThePlateIsNotAtItsPlace) {
  Drive drive = two_planes::Rows();
  for (graph::Keyframe& keyframe : drive.keyframes) keyframe.heights = nullptr;
  const MosaicRenderer renderer(drive.keyframes, drive.metadata, drive.Loader(), Unlevelled());
  EXPECT_TRUE(renderer.Heights().empty());
  EXPECT_GT(Orthophoto(renderer).Rms(kOnPlate), 15);
}

TEST(MosaicHeights, AViewThatDoesNotSeeAPlaceHasNoWeight) {
  // The deck at x = 1.0 is nearer to the middle of the left image, which shows the plate there.
  const Drive drive({{0.4, 0, -1.5707963267948966}, {1.75, 0, -1.5707963267948966}});
  ASSERT_EQ(two_planes::RhoAt(drive.views[0], drive.views[0].ToPixel(1.0, 0)),
            two_planes::kPlateRho);
  const Orthophoto mosaic(
      MosaicRenderer(drive.keyframes, drive.metadata, drive.Loader(), Unlevelled()));
  EXPECT_LT(mosaic.Rms({0.98, -0.2, 0.04, 0.4}), 2);
}

TEST(MosaicHeights, WhatMovesIsLeftOut) {
  Drive drive = two_planes::Rows();
  // A dark object on the plate in the image that shows it best.
  cv::Mat& image = drive.images[5];
  const cv::Point2d at = drive.views[5].ToPixel(0.4, 0.1, two_planes::kPlateRho);
  cv::circle(image, at, 10, cv::Scalar(5), cv::FILLED);
  const Orthophoto mosaic(
      MosaicRenderer(drive.keyframes, drive.metadata, drive.Loader(), Unlevelled()));
  EXPECT_LT(mosaic.Rms({0.35, 0.05, 0.1, 0.1}), 3);
}

TEST(MosaicHeights, AnyWindowShowsTheSameAsTheWhole) {
  const Drive drive = two_planes::Rows();
  const MosaicRenderer renderer(drive.keyframes, drive.metadata, drive.Loader());
  const Orthophoto mosaic(renderer);
  cv::Mat grey;
  cv::Mat alpha;
  const cv::Rect window(37, 51, 90, 70);
  renderer.Render(window, grey, alpha);
  EXPECT_EQ(cv::norm(grey, mosaic.grey(window), cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(alpha, mosaic.alpha(window), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace ceilmap::mosaic
