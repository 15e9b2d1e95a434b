#include "calib/solve/rectification.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/base/degrees.hpp"

namespace ceilmap::calibration {
namespace {

using calib::Lens;

// Tangent of the angle from the axis that the middle of an image's side shows.
double TangentAt(const Lens& lens, double u, double v) {
  constexpr double kMaxAngle = 70 * kRadPerDeg;
  const auto ray = lens.Ray({u, v});
  return std::tan(ray ? std::min(kMaxAngle, std::acos(std::clamp(ray->z(), -1.0, 1.0)))
                      : kMaxAngle);
}

}  // namespace

std::array<double, 4> RectifiedPinhole(const Lens& lens) {
  if (lens.model == calib::LensModel::kEquidistant) {
    const double right = lens.width_px - 1;
    const double bottom = lens.height_px - 1;
    const double left_of = TangentAt(lens, 0, lens.cy);
    const double above = TangentAt(lens, lens.cx, 0);
    const double fx = right / (left_of + TangentAt(lens, right, lens.cy));
    const double fy = bottom / (above + TangentAt(lens, lens.cx, bottom));
    return {fx, fy, fx * left_of, fy * above};
  }
  const cv::Mat K =
      cv::getOptimalNewCameraMatrix(lens.Matrix(), lens.Coefficients(), lens.Size(), 0);
  return {K.at<double>(0, 0), K.at<double>(1, 1), K.at<double>(0, 2), K.at<double>(1, 2)};
}

cv::Mat Rectify(const Lens& lens, const cv::Mat& image) {
  const auto [fx, fy, cx, cy] = RectifiedPinhole(lens);
  cv::Mat2f from(lens.Size(), cv::Vec2f(-1, -1));
  for (int v = 0; v < from.rows; ++v) {
    for (int u = 0; u < from.cols; ++u) {
      const auto pixel = lens.Project({(u - cx) / fx, (v - cy) / fy, 1});
      if (pixel) from(v, u) = {static_cast<float>(pixel->x()), static_cast<float>(pixel->y())};
    }
  }
  cv::Mat rectified;
  cv::remap(image, rectified, from, cv::noArray(), cv::INTER_LINEAR);
  return rectified;
}

}  // namespace ceilmap::calibration
