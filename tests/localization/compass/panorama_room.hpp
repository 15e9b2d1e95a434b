#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/base/pose2.hpp"

namespace ceilmap::compass {

/// A rectangular room whose walls are papered with random colours, seen all around from inside:
/// panoramas with exact truth and true parallax.
class PanoramaRoom {
 public:
  explicit PanoramaRoom(std::uint64_t seed, double length_m = 8, double width_m = 6)
      : length_m_(length_m), width_m_(width_m) {
    cv::RNG random(seed);
    paper_.create(kPaperRows, static_cast<int>(2 * (length_m + width_m) / kGrain), CV_8UC3);
    random.fill(paper_, cv::RNG::UNIFORM, 40, 216);
    cv::GaussianBlur(paper_, paper_, {}, 2.5, 0.8, cv::BORDER_REFLECT);
    cv::normalize(paper_, paper_, 20, 235, cv::NORM_MINMAX);
  }

  /// The room with walls `first` .. `last` of the circumference (0..1) painted over.
  void Paint(double first, double last, const cv::Scalar& colour) {
    paper_.colRange(static_cast<int>(first * paper_.cols), static_cast<int>(last * paper_.cols)) =
        colour;
  }

  [[nodiscard]] cv::Mat Render(const Pose2& pose, int columns = 360, int rows = 15) const {
    cv::Mat panorama(rows, columns, CV_8UC3);
    for (int u = 0; u < columns; ++u) {
      cv::Vec3f sum[kPaperRows] = {};
      constexpr int kRays = 4;  // per column, so that far walls do not alias
      for (int ray = 0; ray < kRays; ++ray) {
        const double column = u + (ray + 0.5) / kRays - 0.5;
        const double azimuth = std::numbers::pi - 2 * std::numbers::pi * column / columns;
        const double at = WallAt(pose, pose.yaw + azimuth) / kGrain;
        const int cell = static_cast<int>(at);
        const auto part = static_cast<float>(at - cell);
        for (int v = 0; v < rows; ++v) {
          const int row = v * kPaperRows / rows;
          const auto& here = paper_.at<cv::Vec3b>(row, cell % paper_.cols);
          const auto& next = paper_.at<cv::Vec3b>(row, (cell + 1) % paper_.cols);
          for (int c = 0; c < 3; ++c) sum[row][c] += (1 - part) * here[c] + part * next[c];
        }
      }
      for (int v = 0; v < rows; ++v) {
        // Several rows of the panorama show one of the paper.
        const int row = v * kPaperRows / rows;
        const int shown = ((row + 1) * rows + kPaperRows - 1) / kPaperRows -
                          (row * rows + kPaperRows - 1) / kPaperRows;
        for (int c = 0; c < 3; ++c) {
          panorama.at<cv::Vec3b>(v, u)[c] =
              cv::saturate_cast<std::uint8_t>(sum[row][c] / static_cast<float>(kRays * shown));
        }
      }
    }
    return panorama;
  }

 private:
  static constexpr double kGrain = 0.02;  // m of wall per column of the paper
  static constexpr int kPaperRows = 15;

  /// Where a ray meets the walls, in metres around the room.
  [[nodiscard]] double WallAt(const Pose2& from, double direction) const {
    const double c = std::cos(direction);
    const double s = std::sin(direction);
    const double to_x = c > 0 ? (length_m_ - from.x) / c : c < 0 ? -from.x / c : 1e9;
    const double to_y = s > 0 ? (width_m_ - from.y) / s : s < 0 ? -from.y / s : 1e9;
    const double x = from.x + std::min(to_x, to_y) * c;
    const double y = from.y + std::min(to_x, to_y) * s;
    const double around = 2 * (length_m_ + width_m_);
    double at = 0;
    if (to_y <= to_x) {
      at = s < 0 ? x : 2 * length_m_ + width_m_ - x;
    } else {
      at = c > 0 ? length_m_ + y : around - y;
    }
    return std::clamp(at, 0.0, around - 1e-6);
  }

  double length_m_;
  double width_m_;
  cv::Mat paper_;
};

}  // namespace ceilmap::compass
