#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/mirror.hpp"

namespace ceilmap::support {

/// A colour panorama with texture at several scales that closes on itself, the same at every call.
inline cv::Mat SyntheticPanorama(cv::Size size) {
  constexpr std::uint64_t kSeed = 20040927;
  cv::RNG random(kSeed);
  cv::Mat sum(size, CV_32FC3, cv::Scalar::all(0));
  for (const int cell : {36, 12, 4}) {
    cv::Mat noise(size.height / cell + 2, size.width / cell, CV_32FC3);
    random.fill(noise, cv::RNG::NORMAL, 0, 1);
    cv::Mat twice;
    cv::hconcat(noise, noise, twice);
    cv::Mat layer;
    cv::resize(twice, layer, {2 * size.width, size.height}, 0, 0, cv::INTER_LINEAR);
    sum += layer(cv::Rect(size.width / 2, 0, size.width, size.height));
  }
  cv::Mat panorama;
  cv::normalize(sum.reshape(1), sum, 20, 235, cv::NORM_MINMAX);
  sum.reshape(3).convertTo(panorama, CV_8U);
  return panorama;
}

/// The panorama after a left turn by this number of columns.
inline cv::Mat TurnedPanorama(const cv::Mat& panorama, int columns) {
  const int right = ((columns % panorama.cols) + panorama.cols) % panorama.cols;
  if (right == 0) return panorama.clone();
  cv::Mat turned;
  cv::hconcat(panorama.colRange(panorama.cols - right, panorama.cols),
              panorama.colRange(0, panorama.cols - right),
              turned);
  return turned;
}

/// The image under a convex mirror that unwraps to the panorama after a left turn by turn_rad.
/// The camera points up, the robot's front is at the image's top, its left at the right.
inline cv::Mat MirrorImage(const cv::Mat& panorama,
                           cv::Size size,
                           const calib::MirrorRing& ring,
                           double turn_rad) {
  constexpr double kTurn = 2 * std::numbers::pi;
  cv::Mat at(size, CV_32FC2);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double right = u - ring.centre_px.x();
      const double up = ring.centre_px.y() - v;
      const double azimuth = std::atan2(right, up) + turn_rad;
      const double part = (ring.outer_radius_px - std::hypot(right, up)) /
                          (ring.outer_radius_px - ring.inner_radius_px);
      double column = (0.5 - azimuth / kTurn) * panorama.cols;
      column -= std::floor(column / panorama.cols) * panorama.cols;
      at.at<cv::Vec2f>(v, u) = {static_cast<float>(column),
                                static_cast<float>(part * panorama.rows - 0.5)};
    }
  }
  cv::Mat closed;  // so that the seam is interpolated too
  cv::hconcat(panorama, panorama.colRange(0, 2), closed);
  cv::Mat image;
  cv::remap(closed, image, at, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return image;
}

}  // namespace ceilmap::support
