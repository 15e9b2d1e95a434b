#include "mapping/mosaic/height_map.hpp"

#include <gtest/gtest.h>

#include "tests/mapping/mosaic/two_planes.hpp"

namespace ceilmap::mosaic {
namespace {

using two_planes::Drive;
using two_planes::kPlate;
using two_planes::kPlateRho;

/// The middle of the plate and of its right border.
const cv::Point2d kMiddle = 0.5 * (kPlate.tl() + kPlate.br());

TEST(HeightMap, IsEmptyWhereNoKeyframeHasHeights) {
  Drive drive = two_planes::Rows();
  for (graph::Keyframe& keyframe : drive.keyframes) keyframe.heights = nullptr;
  const HeightMap map(drive.keyframes, drive.metadata);
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.Grid().width_px, 0);
  EXPECT_EQ(map.RatioAt(0, 0), 0);
  EXPECT_TRUE(map.Sees(drive.views[0], {0, 0}, 1));
  EXPECT_TRUE(map.RatiosOver({0, 0, 10, 10}, {0, 0, 0.01, 10, 10}).empty());
}

TEST(HeightMap, PutsEachSurfaceWhereItIs) {
  const Drive drive = two_planes::Rows();
  const HeightMap map(drive.keyframes, drive.metadata);
  constexpr double kBlock = two_planes::kCellPx * two_planes::kUnitsPerPx;
  for (double y = -0.7; y <= 0.7; y += 0.05) {
    for (double x = -0.7; x <= 1.1; x += 0.05) {
      const cv::Point2d to_edge(std::max(kPlate.x - x, x - kPlate.br().x),
                                std::max(kPlate.y - y, y - kPlate.br().y));
      const double outside = std::max(to_edge.x, to_edge.y);
      if (std::abs(outside) < kBlock) continue;  // blocks cover both
      EXPECT_FLOAT_EQ(map.RatioAt(x, y), outside < 0 ? kPlateRho : 1) << x << ' ' << y;
    }
  }
  EXPECT_EQ(map.RatioAt(3, 3), 0);
  EXPECT_EQ(map.Range(), cv::Vec2f(1, kPlateRho));
}

TEST(HeightMap, OneWrongMeasurementHasNoEffect) {
  Drive drive = two_planes::Rows();
  auto field = std::make_shared<heights::HeightField>(*drive.keyframes[0].heights);
  const std::size_t cell = field->cells.size() / 2;
  const Eigen::Vector2d at = field->Centre(cell);
  const cv::Point2d place = drive.views[0].ToMap(79.5 + at.x(), 59.5 + at.y(), 1.6);
  ASSERT_FALSE(two_planes::OnPlate(place));
  field->cells[cell] = {1.6F, 0.03F};
  drive.keyframes[0].heights = field;
  EXPECT_FLOAT_EQ(HeightMap(drive.keyframes, drive.metadata).RatioAt(place.x, place.y), 1);
}

TEST(HeightMap, ANearerSurfaceHidesWhatIsBehindIt) {
  const Drive drive = two_planes::Rows();
  const HeightMap map(drive.keyframes, drive.metadata);
  // The plate's right border is at x = 0.9. A camera at x = 0.1 sees it in front of the deck up to
  // x = 0.1 + 1.25 * 0.8 = 1.1.
  const ViewPlacement left({0.1, 0, 0}, two_planes::kViewSize, two_planes::kUnitsPerPx);
  const ViewPlacement right({1.2, 0, 0}, two_planes::kViewSize, two_planes::kUnitsPerPx);
  EXPECT_FALSE(map.Sees(left, {1.03, 0}, 1));
  EXPECT_TRUE(map.Sees(left, {1.25, 0}, 1));
  EXPECT_TRUE(map.Sees(left, {0.7, 0}, kPlateRho));
  EXPECT_TRUE(map.Sees(right, {1.03, 0}, 1));
}

TEST(HeightMap, RatiosOverAMosaicAreThoseOfItsPixels) {
  const Drive drive = two_planes::Rows();
  const HeightMap map(drive.keyframes, drive.metadata);
  const store::MosaicGrid mosaic{-0.5, 0.5, 0.01, 150, 100};
  const cv::Mat ratios = map.RatiosOver({30, 20, 80, 60}, mosaic);
  ASSERT_EQ(ratios.size(), cv::Size(80, 60));
  for (const cv::Point pixel : {cv::Point(0, 0), {79, 59}, {45, 30}, {11, 57}}) {
    const double x = mosaic.min_x + (30 + pixel.x + 0.5) * mosaic.resolution;
    const double y = mosaic.max_y - (20 + pixel.y + 0.5) * mosaic.resolution;
    EXPECT_NEAR(ratios.at<float>(pixel), map.RatioAt(x, y), 1e-4) << pixel;
  }
}

}  // namespace
}  // namespace ceilmap::mosaic
