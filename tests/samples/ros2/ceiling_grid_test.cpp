#include "ceilmap_ros/logic/ceiling_grid.hpp"

#include <gtest/gtest.h>

namespace ceilmap_ros {
namespace {

TEST(CeilingGridTest, RowsBeginAtTheSmallestY) {
  const cv::Mat grey = (cv::Mat_<std::uint8_t>(2, 3) << 255, 0, 128, 10, 20, 30);
  const cv::Mat alpha = (cv::Mat_<std::uint8_t>(2, 3) << 255, 255, 255, 255, 0, 1);
  const CeilingGrid grid = ToCeilingGrid({-1, 4, 0.5, 3, 2}, grey, alpha);
  EXPECT_EQ(grid.width, 3U);
  EXPECT_EQ(grid.height, 2U);
  EXPECT_DOUBLE_EQ(grid.resolution_m, 0.5);
  EXPECT_DOUBLE_EQ(grid.origin_x_m, -1);
  EXPECT_DOUBLE_EQ(grid.origin_y_m, 3) << "the lower left corner";
  EXPECT_EQ(grid.cells, (std::vector<std::int8_t>{96, -1, 88, 0, 100, 50}));
}

}  // namespace
}  // namespace ceilmap_ros
