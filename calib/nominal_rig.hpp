#pragma once

#include <opencv2/core.hpp>

#include "calib/rig.hpp"

namespace ceilmap::calib {

/// What is known of an upward camera without a calibration.
struct NominalCamera {
  static constexpr double kMinFovDeg = 5;
  static constexpr double kMaxFovDeg = 150;  ///< beyond it no image is that of a pinhole camera
  static constexpr double kMaxHeightM = 60;

  /// Horizontal field of view (along the image's rows), rad; kMinFovDeg to kMaxFovDeg.
  double fov_rad = 0;
  double ceiling_height_m = 0;  ///< above the floor, > camera_height_m, <= kMaxHeightM
  /// Above the floor, >= 0. At 0 the ceiling's height is counted from the camera.
  double camera_height_m = 0;
};

/// The rig of such a camera: without distortion, square pixels, the principal point in the middle
/// of the image, at the mast above the axle, straight up with the top of the image to the robot's
/// front. Lengths on a map made with it have the relative errors of the distance of the ceiling and
/// of the focal length. Its source_yaml is the file that describes it.
/// @param size  of the images. @throws InputError when a value is out of range.
Rig NominalRig(cv::Size size, const NominalCamera& camera);

}  // namespace ceilmap::calib
