#include "ceilmap_ros/logic/camera_match.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "calib/camera_info.hpp"
#include "calib/robot_rig.hpp"

namespace ceilmap_ros {
namespace {

using ceilmap::InputError;
namespace calib = ceilmap::calib;

/// Largest distance between the pixels that two lenses of one size give to the same ray. Infinite:
/// one of them does not see what the other one sees.
double LargestDistance(const calib::Lens& a, const calib::Lens& b) {
  constexpr int kSteps = 8;
  double largest_px = 0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const Eigen::Vector2d pixel(static_cast<double>(i) * (a.width_px - 1) / kSteps,
                                  static_cast<double>(j) * (a.height_px - 1) / kSteps);
      const auto ray = a.Ray(pixel);
      if (!ray) continue;  // beyond the circle of a fisheye
      const auto other = b.Project(*ray);
      if (!other) return std::numeric_limits<double>::infinity();
      largest_px = std::max(largest_px, (*other - pixel).norm());
    }
  }
  return largest_px;
}

}  // namespace

calib::Lens LensOf(const CameraFacts& camera) {
  if (!camera.Calibrated()) {
    throw InputError(
        "camera_info has no calibration (K is zero); calibrate the camera, or set "
        "camera_from_info to false to use that of the rig");
  }
  if (camera.region_of_interest) {
    throw InputError("camera_info has a region of interest; let the camera send whole images");
  }
  const auto model = calib::FindLensModel(camera.distortion_model);
  if (!model) {
    throw InputError(
        fmt::format("camera_info: distortion_model = {}, must be plumb_bob, "
                    "rational_polynomial or equidistant",
                    camera.distortion_model));
  }
  const std::size_t expected = calib::CoefficientNames(*model).size();
  if (camera.d.size() != expected) {
    throw InputError(fmt::format("camera_info: D has {} coefficients, must be {} for {}",
                                 camera.d.size(),
                                 expected,
                                 camera.distortion_model));
  }
  constexpr std::uint32_t kMaxSide = 1U << 15;
  if (camera.width > kMaxSide || camera.height > kMaxSide) {
    throw InputError("camera_info: width and height must be at most 32768");
  }
  calib::CameraInfo info;
  info.name = "up";
  info.lens.model = *model;
  info.lens.width_px = static_cast<int>(camera.width);
  info.lens.height_px = static_cast<int>(camera.height);
  info.lens.fx = camera.k[0];
  info.lens.cx = camera.k[2];
  info.lens.fy = camera.k[4];
  info.lens.cy = camera.k[5];
  std::copy(camera.d.begin(), camera.d.end(), info.lens.distortion.begin());
  info.rectified = {info.lens.fx, info.lens.fy, info.lens.cx, info.lens.cy};
  // The reader of files has all checks of the values.
  const calib::Lens lens = calib::ParseCameraInfo(calib::FormatCameraInfo(info), "camera_info");
  const cv::Size size(static_cast<int>(camera.width / std::max(1U, camera.binning_x)),
                      static_cast<int>(camera.height / std::max(1U, camera.binning_y)));
  return size == lens.Size() ? lens : calib::ScaledTo(lens, size);
}

std::optional<std::string> Mismatch(const calib::Lens& rig, const CameraFacts& camera) {
  if (!camera.Calibrated()) return std::nullopt;
  try {
    const calib::Lens published = LensOf(camera);
    const double distance_px = LargestDistance(rig, calib::ScaledTo(published, rig.Size()));
    constexpr double kLargestShare = 0.01;
    if (distance_px <= kLargestShare * rig.width_px) return std::nullopt;
    return fmt::format(
        "camera_info differs from the rig by up to {:.1f} px of {} px; calibrate "
        "again, or set camera_from_info",
        distance_px,
        rig.width_px);
  } catch (const InputError& error) {
    return error.what();
  }
}

}  // namespace ceilmap_ros
