#include "samples/simulator/camera_rays.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ceilmap::simulator {
CameraRays::CameraRays(const calib::Lens& camera) : camera_(camera), size_(camera.Size()) {
  if (camera_.IsDistorted()) {
    taps_.create(2 * size_.height, 2 * size_.width, CV_32FC2);
    for (int r = 0; r < taps_.rows; ++r) {
      for (int c = 0; c < taps_.cols; ++c) {
        taps_.at<cv::Vec2f>(r, c) = cv::Point2f(Undistort((c - 0.5) / 2, (r - 0.5) / 2));
      }
    }
  }
  for (int c = 0; c < 2 * size_.width; ++c) column_x_.push_back(static_cast<float>(Tap(0, c).x));
  blocks_ = MakeBlocks(cv::Rect(cv::Point(), size_), kBlockSize);
}

cv::Point2d CameraRays::Undistort(double u, double v) const {
  const auto ray = camera_.Ray({u, v});
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  constexpr double kMinDepth = 0.0175;  // 89 deg from the axis: farther out the image is dark
  if (!ray || !(ray->z() > kMinDepth)) return {nothing, nothing};
  return {ray->x() / ray->z(), ray->y() / ray->z()};
}

cv::Point2d CameraRays::Tap(int tap_row, int tap_column) const {
  if (!taps_.empty()) return cv::Point2f(taps_.at<cv::Vec2f>(tap_row, tap_column));
  return {((tap_column - 0.5) / 2 - camera_.cx) / camera_.fx,
          ((tap_row - 0.5) / 2 - camera_.cy) / camera_.fy};
}

void CameraRays::TapRow(int tap_row, int first, int count, float* x, float* y) const {
  if (taps_.empty()) {
    std::copy_n(&column_x_[first], count, x);
    std::fill_n(y, count, static_cast<float>(Tap(tap_row, 0).y));
    return;
  }
  const auto* taps = taps_.ptr<cv::Vec2f>(tap_row) + first;
  for (int i = 0; i < count; ++i) {
    x[i] = taps[i][0];
    y[i] = taps[i][1];
  }
}

cv::Point2d CameraRays::Ray(int u, int v, double du, double dv) const {
  if (taps_.empty()) {
    return {(u + du - camera_.cx) / camera_.fx, (v + dv - camera_.cy) / camera_.fy};
  }
  // Within a pixel the distortion is linear: the taps give centre and derivative.
  const cv::Point2d a = Tap(2 * v, 2 * u);
  const cv::Point2d b = Tap(2 * v, 2 * u + 1);
  const cv::Point2d c = Tap(2 * v + 1, 2 * u);
  const cv::Point2d d = Tap(2 * v + 1, 2 * u + 1);
  return 0.25 * (a + b + c + d) + du * (b + d - a - c) + dv * (c + d - a - b);
}

/// A pixel; half of one is needed. Towards the rim of a wide lens, pixels are larger.
double CameraRays::Margin(const cv::Rect& taps) const {
  double margin = PixelSpan();
  if (taps_.empty()) return margin;
  const auto add = [&margin](const cv::Point2d& a, const cv::Point2d& b) {
    const cv::Point2d step = a - b;
    margin = std::fmax(margin, 2 * std::fmax(std::abs(step.x), std::abs(step.y)));
  };
  for (int r = taps.y; r < taps.y + taps.height; ++r) {
    for (int c = taps.x; c < taps.x + taps.width; ++c) {
      if (c > taps.x) add(Tap(r, c), Tap(r, c - 1));
      if (r > taps.y) add(Tap(r, c), Tap(r - 1, c));
    }
  }
  return margin;
}

std::vector<CameraRays::Block> CameraRays::MakeBlocks(const cv::Rect& pixels, int size) const {
  std::vector<Block> blocks;
  for (int v = pixels.y; v < pixels.y + pixels.height; v += size) {
    for (int u = pixels.x; u < pixels.x + pixels.width; u += size) {
      Block block{cv::Rect(u, v, size, size) & pixels, {}, true, {}};
      cv::Point2d low(1e9, 1e9);
      cv::Point2d high(-1e9, -1e9);
      const cv::Rect taps(2 * u, 2 * v, 2 * block.pixels.width, 2 * block.pixels.height);
      for (int r = taps.y; r < taps.y + taps.height; ++r) {
        for (int c = taps.x; c < taps.x + taps.width; ++c) {
          const cv::Point2d ray = Tap(r, c);
          if (std::isnan(ray.x)) block.whole = false;
          low = {std::fmin(low.x, ray.x), std::fmin(low.y, ray.y)};
          high = {std::fmax(high.x, ray.x), std::fmax(high.y, ray.y)};
        }
      }
      const double margin = Margin(taps);
      const cv::Point2d border(margin, margin);
      block.rays = high.x < low.x ? cv::Rect2d(0, 0, -1, -1)  // outside the lens's field of view
                                  : cv::Rect2d(low - border, high + border);
      if (size > kPartSize) block.parts = MakeBlocks(block.pixels, kPartSize);
      blocks.push_back(std::move(block));
    }
  }
  return blocks;
}

}  // namespace ceilmap::simulator
