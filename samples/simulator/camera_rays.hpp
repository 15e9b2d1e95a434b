#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/lens.hpp"

namespace ceilmap::simulator {

/// The rays of a camera's pixels. Each pixel has four taps at (u +- 0.25, v +- 0.25): tap (row r,
/// column c) of the image lies at u = (c - 0.5) / 2, v = (r - 0.5) / 2. A ray is the point (x, y,
/// 1) of the optical frame, without distortion. Pixels more than 89 degrees from the axis have
/// none.
class CameraRays {
 public:
  /// A part of the image and the bounding rectangle of x and y of its pixels' rays, borders
  /// included. It has a negative size when no pixel has a ray. `whole`: all pixels have one.
  struct Block {
    cv::Rect pixels;
    cv::Rect2d rays;
    bool whole = true;
    std::vector<Block> parts;  ///< of kPartSize pixels; a part has no parts
  };
  static constexpr int kBlockSize = 32;  // pixels
  static constexpr int kPartSize = 8;

  explicit CameraRays(const calib::Lens& camera);

  [[nodiscard]] cv::Size Size() const { return size_; }
  /// Size of a pixel at a depth of one metre.
  [[nodiscard]] double PixelSpan() const { return 1 / std::min(camera_.fx, camera_.fy); }
  [[nodiscard]] const std::vector<Block>& Blocks() const { return blocks_; }

  /// Rays of the taps first..first+count-1 of a row of taps. NaN outside the lens's field of view.
  void TapRow(int tap_row, int first, int count, float* x, float* y) const;

  /// The ray at an offset, in pixels, from the pixel's centre.
  [[nodiscard]] cv::Point2d Ray(int u, int v, double du, double dv) const;

 private:
  [[nodiscard]] cv::Point2d Undistort(double u, double v) const;
  [[nodiscard]] cv::Point2d Tap(int tap_row, int tap_column) const;
  [[nodiscard]] double Margin(const cv::Rect& taps) const;
  [[nodiscard]] std::vector<Block> MakeBlocks(const cv::Rect& pixels, int size) const;

  calib::Lens camera_;
  cv::Size size_;
  cv::Mat taps_;                 // CV_32FC2, x and y of each tap; empty without distortion
  std::vector<float> column_x_;  // x of each tap column; without distortion
  std::vector<Block> blocks_;
};

}  // namespace ceilmap::simulator
