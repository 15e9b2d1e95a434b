#include "mapping/mosaic/preview_mosaic.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ceilmap::mosaic {
namespace {

constexpr int kImageSide = 200;  // side of one image on the mosaic, initially, pixels
constexpr int kBlock = 128;      // the mosaic grows in steps of this number of pixels

/// Smallest box around the image's corners.
cv::Rect2d ExtentOf(const Pose2& T_map_view, double width, double height) {
  double min_x = T_map_view.x;
  double max_x = min_x;
  double min_y = T_map_view.y;
  double max_y = min_y;
  for (const double u : {-0.5, 0.5}) {
    for (const double v : {-0.5, 0.5}) {
      const Eigen::Vector2d corner = T_map_view * Eigen::Vector2d(u * width, v * height);
      min_x = std::min(min_x, corner.x());
      max_x = std::max(max_x, corner.x());
      min_y = std::min(min_y, corner.y());
      max_y = std::max(max_y, corner.y());
    }
  }
  return {min_x, min_y, max_x - min_x, max_y - min_y};
}

int Blocks(double pixels) {
  return kBlock * static_cast<int>(std::ceil(std::max(pixels, 0.0) / kBlock));
}

}  // namespace

LiveMosaic::LiveMosaic(const calib::CeilingView& view, int max_px) : view_(view), max_px_(max_px) {}

void LiveMosaic::MakeRoomFor(const cv::Rect2d& extent) {
  if (grey_.empty()) {
    min_x_ = extent.x;
    max_y_ = extent.y + extent.height;
  }
  const int left = Blocks((min_x_ - extent.x) / resolution_);
  const int top = Blocks((extent.y + extent.height - max_y_) / resolution_);
  const double max_x = min_x_ + resolution_ * grey_.cols;
  const double min_y = max_y_ - resolution_ * grey_.rows;
  const int right = Blocks((extent.x + extent.width - max_x) / resolution_);
  const int bottom = Blocks((min_y - extent.y) / resolution_);
  if (left + top + right + bottom > 0) {
    const cv::Size size(grey_.cols + left + right, grey_.rows + top + bottom);
    for (cv::Mat* image : {&grey_, &alpha_}) {
      cv::Mat grown(size, CV_8UC1, cv::Scalar(0));
      if (!image->empty()) image->copyTo(grown({left, top, image->cols, image->rows}));
      *image = grown;
    }
    min_x_ -= left * resolution_;
    max_y_ += top * resolution_;
  }
  while (std::max(grey_.cols, grey_.rows) > max_px_) {
    for (cv::Mat* image : {&grey_, &alpha_}) {
      cv::Mat halved;
      cv::resize(*image, halved, {}, 0.5, 0.5, cv::INTER_NEAREST);
      *image = halved;
    }
    resolution_ *= 2;
  }
}

void LiveMosaic::Add(const cv::Mat& rectified, const Pose2& T_map_base) {
  const Pose2 T_map_view = T_map_base * view_.T_base_view();
  const double width = view_.MetresPerPixel() * view_.Size().width;
  const double height = view_.MetresPerPixel() * view_.Size().height;
  if (resolution_ == 0) resolution_ = std::max(width, height) / kImageSide;
  const cv::Rect2d extent = ExtentOf(T_map_view, width, height);
  MakeRoomFor(extent);

  const cv::Size size(std::max(1, static_cast<int>(std::lround(width / resolution_))),
                      std::max(1, static_cast<int>(std::lround(height / resolution_))));
  cv::resize(rectified, small_, size, 0, 0, cv::INTER_AREA);
  if (view_.Mask().empty()) {
    small_mask_.create(size, CV_8UC1);
    small_mask_.setTo(255);
  } else {
    cv::resize(view_.Mask(), small_mask_, size, 0, 0, cv::INTER_NEAREST);
  }
  // From pixels of the small image to those of the mosaic, whose y points down.
  const double unit_u = width / size.width / resolution_;
  const double unit_v = height / size.height / resolution_;
  const double c = std::cos(T_map_view.yaw);
  const double s = std::sin(T_map_view.yaw);
  const double mid_u = 0.5 * (size.width - 1);
  const double mid_v = 0.5 * (size.height - 1);
  cv::Matx23d m(c * unit_u, -s * unit_v, 0, -s * unit_u, -c * unit_v, 0);
  m(0, 2) = (T_map_view.x - min_x_) / resolution_ - 0.5 - m(0, 0) * mid_u - m(0, 1) * mid_v;
  m(1, 2) = (max_y_ - T_map_view.y) / resolution_ - 0.5 - m(1, 0) * mid_u - m(1, 1) * mid_v;
  const cv::Rect window = WindowOf(extent);
  m(0, 2) -= window.x;
  m(1, 2) -= window.y;
  cv::warpAffine(small_, turned_, m, window.size(), cv::INTER_LINEAR);
  cv::warpAffine(small_mask_, turned_mask_, m, window.size(), cv::INTER_NEAREST);
  turned_.copyTo(grey_(window), turned_mask_);
  alpha_(window).setTo(255, turned_mask_);
}

cv::Rect LiveMosaic::WindowOf(const cv::Rect2d& extent) const {
  const int left = static_cast<int>(std::floor((extent.x - min_x_) / resolution_));
  const int top = static_cast<int>(std::floor((max_y_ - extent.y - extent.height) / resolution_));
  const int width = static_cast<int>(std::ceil(extent.width / resolution_)) + 2;
  const int height = static_cast<int>(std::ceil(extent.height / resolution_)) + 2;
  return cv::Rect(left, top, width, height) & cv::Rect(0, 0, grey_.cols, grey_.rows);
}

Mosaic LiveMosaic::Copy() const {
  return {grey_.clone(), alpha_.clone(), {min_x_, max_y_, resolution_, grey_.cols, grey_.rows}};
}

}  // namespace ceilmap::mosaic
