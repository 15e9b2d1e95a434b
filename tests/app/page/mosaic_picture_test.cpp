#include "app/page/mosaic_picture.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tests/mapping/store/synthetic_map.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::page {
namespace {

// The left half of the ceiling is mapped, bright at the top; noise dominates the size of the
// picture.
struct HalfMapped {
  explicit HalfMapped(store::MosaicGrid where, double noise) : grid(where) {
    grey.create(grid.height_px, grid.width_px, CV_8UC1);
    alpha = cv::Mat::zeros(grey.size(), CV_8UC1);
    cv::RNG random(1);
    random.fill(grey, cv::RNG::NORMAL, 100, noise);
    grey.rowRange(0, grey.rows / 2) += 80;
    alpha.colRange(0, grey.cols / 2).setTo(255);
  }
  store::MosaicGrid grid;
  cv::Mat grey;
  cv::Mat alpha;
};

cv::Mat Decoded(const PagePicture& picture) {
  return cv::imdecode(picture.bytes, cv::IMREAD_UNCHANGED);
}

// Mean of one channel in the middle of a part of the picture, given by its corners in [0, 1].
double MeanIn(const cv::Mat& picture, int channel, cv::Rect2d part) {
  const cv::Rect window(static_cast<int>(part.x * picture.cols) + 1,
                        static_cast<int>(part.y * picture.rows) + 1,
                        static_cast<int>(part.width * picture.cols) - 2,
                        static_cast<int>(part.height * picture.rows) - 2);
  return cv::mean(picture(window))[channel];
}

void ExpectHalfMapped(const cv::Mat& picture) {
  ASSERT_EQ(picture.channels(), 4);
  EXPECT_NEAR(MeanIn(picture, 0, {0, 0, 0.5, 0.5}), 180, 6);
  EXPECT_NEAR(MeanIn(picture, 0, {0, 0.5, 0.5, 0.5}), 100, 6);
  EXPECT_GT(MeanIn(picture, 3, {0, 0, 0.5, 1}), 250);
  EXPECT_LT(MeanIn(picture, 3, {0.5, 0, 0.5, 1}), 5);
}

TEST(MakePicture, LiesWhereTheMosaicLiesWithTheUnseenTransparent) {
  const HalfMapped scene({-3, 2, 0.01, 300, 200}, 5);
  const PagePicture picture = MakePicture(scene.grey, scene.alpha, scene.grid);
  EXPECT_EQ(picture.min_x, -3);
  EXPECT_DOUBLE_EQ(picture.max_x, 0);
  EXPECT_DOUBLE_EQ(picture.min_y, 0);
  EXPECT_EQ(picture.max_y, 2);
  EXPECT_EQ(Decoded(picture).size(), cv::Size(300, 200));
  ExpectHalfMapped(Decoded(picture));
}

TEST(MakePicture, FitsIntoItsBytes) {
  const HalfMapped scene({0, 0, 0.01, 1200, 800}, 25);
  std::size_t before = 0;
  for (const std::size_t max_bytes : {3000U, 20'000U, 120'000U}) {
    const PagePicture picture = MakePicture(scene.grey, scene.alpha, scene.grid, max_bytes);
    EXPECT_LE(picture.bytes.size(), max_bytes);
    EXPECT_GT(picture.bytes.size(), before) << "less was possible before";
    EXPECT_DOUBLE_EQ(picture.max_x, 12);
    EXPECT_DOUBLE_EQ(picture.min_y, -8);
    ExpectHalfMapped(Decoded(picture));
    before = picture.bytes.size();
  }
}

TEST(MakePicture, HasNoDarkRimAfterShrinking) {
  HalfMapped scene({0, 0, 0.01, 1202, 802}, 25);
  scene.alpha.setTo(0);
  scene.alpha.colRange(0, 603).setTo(255);
  scene.grey.colRange(603, 1202).setTo(0);
  const cv::Mat picture = Decoded(MakePicture(scene.grey, scene.alpha, scene.grid, 20'000));
  ASSERT_LT(picture.cols, 700);
  int last = 0;
  while (picture.at<cv::Vec4b>(picture.rows / 4, last + 1)[3] > 20) ++last;
  const cv::Mat rim = picture.rowRange(5, picture.rows / 2 - 5).colRange(last, last + 1);
  EXPECT_GT(cv::mean(rim)[0], 150);
}

TEST(MakePicture, IsEmptyWithoutAMosaic) {
  EXPECT_TRUE(MakePicture({}, {}, {}).empty());
}

TEST(MakePicture, RefusesOtherSizes) {
  const HalfMapped scene({0, 0, 0.01, 30, 20}, 5);
  EXPECT_THROW(MakePicture(scene.grey, scene.alpha, {0, 0, 0.01, 31, 20}), std::invalid_argument);
  EXPECT_THROW(MakePicture(scene.grey, {}, scene.grid), std::invalid_argument);
}

TEST(MakeMosaicPicture, IsTheOverviewOfAMap) {
  const support::TestFolder folder;
  const HalfMapped scene({-3, 2, 0.01, 800, 600}, 5);
  store::MapWriter writer(folder / "map.gpkg", store::synthetic::SmallMap().metadata);
  writer.WriteMosaic(scene.grid, [&](const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) {
    scene.grey(window).copyTo(grey);
    scene.alpha(window).copyTo(alpha);
  });
  writer.Commit();
  const PagePicture picture = MakeMosaicPicture(store::MapReader(folder / "map.gpkg"), 400);
  EXPECT_EQ(picture.min_x, -3);
  EXPECT_DOUBLE_EQ(picture.max_x, 5);
  EXPECT_DOUBLE_EQ(picture.min_y, -4);
  EXPECT_EQ(picture.max_y, 2);
  EXPECT_EQ(Decoded(picture).size(), cv::Size(400, 300));
  ExpectHalfMapped(Decoded(picture));
}

}  // namespace
}  // namespace ceilmap::page
