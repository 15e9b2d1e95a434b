#include "mapping/mosaic/preview_mosaic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ceilmap::mosaic {
namespace {

/// A ceiling with one bright spot, and its image at a pose.
cv::Mat ImageAt(const calib::CeilingView& view,
                const Pose2& T_map_base,
                const Eigen::Vector2d& spot) {
  cv::Mat image(view.Size(), CV_8UC1, cv::Scalar(50));
  const Eigen::Vector2d p_view = (T_map_base * view.T_base_view()).Inverse() * spot;
  const cv::Point2d pixel(p_view.x() / view.MetresPerPixel() + 0.5 * (view.Size().width - 1),
                          p_view.y() / view.MetresPerPixel() + 0.5 * (view.Size().height - 1));
  cv::circle(image, pixel, 12, cv::Scalar(255), cv::FILLED);
  return image;
}

/// Where the mosaic has it.
Eigen::Vector2d SpotOn(const Mosaic& mosaic) {
  cv::Mat bright;
  cv::threshold(mosaic.grey, bright, 150, 255, cv::THRESH_BINARY);
  const cv::Moments m = cv::moments(bright, true);
  return {mosaic.grid.min_x + (m.m10 / m.m00 + 0.5) * mosaic.grid.resolution,
          mosaic.grid.max_y - (m.m01 / m.m00 + 0.5) * mosaic.grid.resolution};
}

calib::CeilingView View() {
  return calib::CeilingView::OfRectified({320, 240}, 0.01, {0.2, -0.1, -1.5});
}

TEST(LiveMosaic, IsEmptyBeforeTheFirstImage) {
  const calib::CeilingView view = View();
  EXPECT_TRUE(LiveMosaic(view).Copy().grey.empty());
}

TEST(LiveMosaic, ImagesLieWhereTheyWereTaken) {
  const calib::CeilingView view = View();
  const Eigen::Vector2d spot(4.1, -2.3);
  for (const Pose2& pose : {Pose2{4, -2, 0}, {4.3, -2.6, 2}, {3.7, -2.1, -1.2}, {4, -3, 3.1}}) {
    LiveMosaic mosaic(view);
    mosaic.Add(ImageAt(view, pose, spot), pose);
    const Mosaic copy = mosaic.Copy();
    EXPECT_LT((SpotOn(copy) - spot).norm(), copy.grid.resolution);
  }
}

TEST(LiveMosaic, GrowsToAllSidesWithoutMovingWhatIsThere) {
  const calib::CeilingView view = View();
  const Eigen::Vector2d spot(0.3, 0.2);
  LiveMosaic mosaic(view);
  mosaic.Add(ImageAt(view, {}, spot), {});
  for (const Pose2& far : {Pose2{5, 0, 0.3}, {-5, 0, 0.3}, {0, 5, 0.3}, {0, -5, 0.3}}) {
    mosaic.Add(cv::Mat(view.Size(), CV_8UC1, cv::Scalar(50)), far);
    const Mosaic copy = mosaic.Copy();
    EXPECT_LT((SpotOn(copy) - spot).norm(), copy.grid.resolution);
  }
  const Mosaic copy = mosaic.Copy();
  EXPECT_GT(copy.grey.cols * copy.grid.resolution, 12);
  EXPECT_EQ(cv::countNonZero(copy.grey & ~copy.alpha), 0) << "unseen is black";
}

TEST(LiveMosaic, TheNewestImageIsOnTop) {
  const calib::CeilingView view = View();
  LiveMosaic mosaic(view);
  mosaic.Add(cv::Mat(view.Size(), CV_8UC1, cv::Scalar(50)), {});
  mosaic.Add(cv::Mat(view.Size(), CV_8UC1, cv::Scalar(90)), {});
  const Mosaic copy = mosaic.Copy();
  EXPECT_EQ(copy.grey.at<uchar>(copy.grey.rows / 3, copy.grey.cols / 3), 90);
}

TEST(LiveMosaic, StaysSmallHoweverFarTheRobotGoes) {
  const calib::CeilingView view = View();
  const Eigen::Vector2d spot(0.3, 0.2);
  LiveMosaic mosaic(view, 600);
  mosaic.Add(ImageAt(view, {}, spot), {});
  for (int i = 1; i < 200; ++i) {
    mosaic.Add(cv::Mat(view.Size(), CV_8UC1, cv::Scalar(50)), {1.0 * i, 0.5 * i, 0.1 * i});
  }
  const Mosaic copy = mosaic.Copy();
  EXPECT_LE(std::max(copy.grey.cols, copy.grey.rows), 600);
  EXPECT_GT(copy.grid.resolution * copy.grey.cols, 199);
  const cv::Rect all(0, 0, copy.grey.cols, copy.grey.rows);
  EXPECT_EQ(all.width, copy.grid.width_px);
  EXPECT_EQ(all.height, copy.grid.height_px);
}

}  // namespace
}  // namespace ceilmap::mosaic
