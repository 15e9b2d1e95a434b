#include "mapping/mosaic/tile_rows.hpp"

#include <gtest/gtest.h>

namespace ceilmap::mosaic {
namespace {

const cv::Size kImageSize(80, 60);

/// Columns of the row whose pixel lies in the image for some ratio.
cv::Range Brute(const ViewPlacement& view,
                cv::Size size,
                const store::MosaicGrid& grid,
                int row,
                const std::vector<double>& ratios) {
  cv::Range columns(grid.width_px, 0);
  const double y = grid.max_y - (row + 0.5) * grid.resolution;
  for (int col = 0; col < grid.width_px; ++col) {
    const double x = grid.min_x + (col + 0.5) * grid.resolution;
    for (const double rho : ratios) {
      const cv::Point2d pixel = view.ToPixel(x, y, rho);
      if (pixel.x < 0 || pixel.y < 0 || pixel.x > size.width - 1 || pixel.y > size.height - 1) {
        continue;
      }
      columns = {std::min(columns.start, col), std::max(columns.end, col + 1)};
    }
  }
  return columns;
}

void ExpectCovers(const cv::Point2d& principal_px) {
  const ViewPlacement view({0.103, 0.052, 0}, kImageSize, 0.01, principal_px);
  const store::MosaicGrid grid{-1, 1, 0.01, 200, 200};
  const cv::Rect tile(0, 0, 200, 200);
  cv::Mat ratios(tile.size(), CV_32FC1, cv::Scalar(1.5));
  ratios.at<float>(0, 0) = 0.8F;
  for (int row = 0; row < 200; ++row) {
    const cv::Range expected = Brute(view, kImageSize, grid, row, {0.8, 1, 1.2, 1.5});
    const RowMap map = MapRow(view, kImageSize, grid, tile, row, TileRatios(ratios));
    if (expected.start >= expected.end) continue;
    EXPECT_LE(map.first, expected.start) << row;
    EXPECT_GE(map.last, expected.end) << row;
  }
}

TEST(MapRow, CoversThePixelsOfAllRatios) {
  ExpectCovers({0, 0});
}
TEST(MapRow, CoversThemWhereThePrincipalPointIsOutsideOfTheImage) {
  ExpectCovers({60, -45});
}

TEST(MapRow, OnTheReferencePlaneHasThePixelsInsideTheImage) {
  const ViewPlacement view({0.103, 0.052, 0}, kImageSize, 0.01, {60, -45});
  const store::MosaicGrid grid{-1, 1, 0.01, 200, 200};
  const RowMap map = MapRow(view, kImageSize, grid, {0, 0, 200, 200}, 100, TileRatios({}));
  const cv::Range expected = Brute(view, kImageSize, grid, 100, {1});
  EXPECT_EQ(map.first, expected.start);
  EXPECT_EQ(map.last, expected.end);
  EXPECT_GT(map.last, map.first);
}

}  // namespace
}  // namespace ceilmap::mosaic
