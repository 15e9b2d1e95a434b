#include "mapping/mosaic/floor_heights.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace ceilmap::mosaic {
namespace {

/// Images of 64 x 48 px, 1 cm per pixel on a ceiling at 3 m, 2.5 m above the camera.
store::MapMetadata Metadata() {
  store::MapMetadata metadata;
  metadata.resolution = 0.01;
  metadata.ceiling_height_m = 3;
  metadata.view_size = {64, 48};
  metadata.view_units_per_px = 0.01;
  metadata.view_focal_px = 250;
  return metadata;
}

/// With heights where `rho` > 0. The view's frame is that of the map, moved by `x`.
graph::Keyframe At(std::int64_t id, double x, float rho) {
  graph::Keyframe keyframe;
  keyframe.id = id;
  keyframe.pose.T_map_base = {x, 0, 0};
  if (rho == 0) return keyframe;
  auto field = std::make_shared<heights::HeightField>();
  field->grid = {8, 6};
  field->first_px = {-28, -20};
  field->step_px = {8, 8};
  field->cells.assign(48, {rho, 0.01F});
  keyframe.heights = field;
  return keyframe;
}

float HeightAt(const FloorHeights& heights, double x, double y) {
  const store::MosaicGrid pixel{x - 0.5e-3, y + 0.5e-3, 1e-3, 1, 1};
  return heights.Window(pixel, {0, 0, 1, 1}).at<float>(0, 0);
}

TEST(FloorHeights, AreMetresAboveTheFloor) {
  const FloorHeights heights({At(0, 0, 1.25F)}, Metadata());
  ASSERT_FALSE(heights.empty());
  EXPECT_NEAR(HeightAt(heights, 0, 0), 0.5 + 2.5 / 1.25, 1e-5);
  EXPECT_TRUE(std::isnan(HeightAt(heights, 3, 0)));
}

TEST(FloorHeights, AreThoseOfThePlaneWhereAnImageShowsAPlane) {
  const FloorHeights heights({At(0, 0, 1.25F), At(1, 0.4, 0)}, Metadata());
  EXPECT_NEAR(HeightAt(heights, 0, 0), 2.5, 1e-5) << "measured, although the other image shows it";
  EXPECT_NEAR(HeightAt(heights, 0.6, 0), 3, 1e-5);
  EXPECT_NEAR(HeightAt(heights, 0.71, 0.22), 3, 1e-5);
  EXPECT_TRUE(std::isnan(HeightAt(heights, 0.73, 0)));
  EXPECT_TRUE(std::isnan(HeightAt(heights, 0.6, 0.26)));
}

TEST(FloorHeights, DoNotDependOnTheWindow) {
  const FloorHeights heights({At(0, 0, 1.25F), At(1, 0.7, 1.1F), At(2, 1.2, 0)}, Metadata());
  const store::MosaicGrid grid{-0.5, 0.5, 0.003, 700, 333};
  const cv::Mat whole = heights.Window(grid, {0, 0, 700, 333});
  for (const cv::Rect& window :
       {cv::Rect(0, 0, 1, 1), cv::Rect(100, 50, 300, 200), cv::Rect(650, 300, 50, 33)}) {
    const cv::Mat part = heights.Window(grid, window);
    for (int row = 0; row < window.height; ++row) {
      for (int col = 0; col < window.width; ++col) {
        const float a = part.at<float>(row, col);
        const float b = whole.at<float>(row + window.y, col + window.x);
        ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << row << ' ' << col;
      }
    }
  }
}

TEST(FloorHeights, AreEmptyWithoutDepthAndWithoutMetres) {
  EXPECT_TRUE(FloorHeights({At(0, 0, 0)}, Metadata()).empty());
  store::MapMetadata metadata = Metadata();
  metadata.view_focal_px = 0;
  const FloorHeights heights({At(0, 0, 1.25F)}, metadata);
  EXPECT_TRUE(heights.empty());
  EXPECT_TRUE(std::isnan(HeightAt(heights, 0, 0)));
  metadata = Metadata();
  metadata.unit = "px";
  EXPECT_TRUE(FloorHeights({At(0, 0, 1.25F)}, metadata).empty());
}

}  // namespace
}  // namespace ceilmap::mosaic
