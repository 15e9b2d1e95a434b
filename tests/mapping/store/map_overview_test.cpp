#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "mapping/store/map_file.hpp"
#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap::store {
namespace {

/// Grey rises smoothly to the right and down; everything below the diagonal was never seen.
constexpr MosaicGrid kSlope{-3.0, 2.0, 0.01, 2100, 1100};
double SlopeAt(double x, double y) {
  return 20 + x / 20 + y / 20;
}
void FillSlope(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
  grey.create(window.size(), CV_8UC1);
  alpha.create(window.size(), CV_8UC1);
  for (int y = 0; y < window.height; ++y) {
    for (int x = 0; x < window.width; ++x) {
      const bool seen = window.x + x > window.y + y;
      grey.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(
          seen ? SlopeAt(window.x + x + 0.5, window.y + y + 0.5) : 0);
      alpha.at<std::uint8_t>(y, x) = seen ? 255 : 0;
    }
  }
}

class MapOverview : public testing::Test {
 protected:
  void SetUp() override {
    MapWriter writer(folder_ / "map.gpkg", synthetic::SmallMap().metadata);
    writer.WriteMosaic(kSlope, FillSlope);
    writer.Commit();
  }
  support::TempFolder folder_;
};

TEST_F(MapOverview, IsTheMosaicWhereThatIsSmallEnough) {
  const MapReader reader(folder_ / "map.gpkg");
  cv::Mat grey;
  cv::Mat alpha;
  const MosaicGrid grid = reader.ReadOverview(2100, grey, alpha);
  EXPECT_EQ(grid.width_px, 2100);
  EXPECT_EQ(grid.resolution, 0.01);
  cv::Mat whole_grey;
  cv::Mat whole_alpha;
  reader.ReadMosaic({0, 0, 2100, 1100}, whole_grey, whole_alpha);
  EXPECT_EQ(cv::norm(grey, whole_grey, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(alpha, whole_alpha, cv::NORM_INF), 0);
}

TEST_F(MapOverview, LiesWhereTheMosaicLies) {
  const MapReader reader(folder_ / "map.gpkg");
  for (const int max_px : {1000, 300, 37}) {
    cv::Mat grey;
    cv::Mat alpha;
    const MosaicGrid grid = reader.ReadOverview(max_px, grey, alpha);
    const int factor = max_px == 1000 ? 4 : max_px == 300 ? 8 : 64;
    EXPECT_EQ(grid.width_px, 2100 / factor);
    EXPECT_EQ(grid.height_px, 1100 / factor);
    EXPECT_EQ(grey.size(), cv::Size(grid.width_px, grid.height_px));
    EXPECT_EQ(alpha.size(), grey.size());
    EXPECT_EQ(grid.min_x, kSlope.min_x);
    EXPECT_EQ(grid.max_y, kSlope.max_y);
    EXPECT_DOUBLE_EQ(grid.resolution, factor * kSlope.resolution);
    for (int y = 1; y < grid.height_px - 1; ++y) {
      for (int x = 1; x < grid.width_px - 1; ++x) {
        if (x > y + 1) {
          // Unseen pixels must not darken what is seen.
          ASSERT_NEAR(
              grey.at<std::uint8_t>(y, x), SlopeAt((x + 0.5) * factor, (y + 0.5) * factor), 2)
              << x << ' ' << y << " of " << max_px;
          ASSERT_EQ(alpha.at<std::uint8_t>(y, x), 255) << x << ' ' << y;
        } else if (x < y - 1) {
          ASSERT_EQ(alpha.at<std::uint8_t>(y, x), 0) << x << ' ' << y;
        }
      }
    }
  }
}

TEST_F(MapOverview, OfAMapWithoutAMosaicIsEmpty) {
  {
    MapWriter writer(folder_ / "none.gpkg", synthetic::SmallMap().metadata);
    writer.WriteMosaic({0, 0, 1, 0, 0}, FillSlope);
    writer.Commit();
  }
  cv::Mat grey(3, 3, CV_8UC1);
  cv::Mat alpha;
  const MosaicGrid grid = MapReader(folder_ / "none.gpkg").ReadOverview(100, grey, alpha);
  EXPECT_EQ(grid.width_px, 0);
  EXPECT_TRUE(grey.empty());
}

}  // namespace
}  // namespace ceilmap::store
