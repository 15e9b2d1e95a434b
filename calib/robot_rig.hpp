#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "calib/rig.hpp"

namespace ceilmap::calib {

/// A camera of a rig that was scaled to the size of a recording's images.
struct CameraScaling {
  std::string camera;  ///< its name in the rig: up, forward, omni
  std::string source;  ///< name of the recording
  cv::Size rig_size;   ///< of the images that the rig describes
  cv::Size size;       ///< of the recording's images

  /// One line for the user.
  [[nodiscard]] std::string Text() const;
};

/// The same camera with images of another size: focal lengths and principal point are scaled by the
/// ratios of the widths and heights, where the image's corner stays at pixel (-0.5, -0.5). The
/// distortion coefficients do not depend on the size.
Lens ScaledTo(const Lens& camera, cv::Size size);

/// Prepares a camera of the rig for a recording: the camera is scaled where the recording has the
/// same images in another size. Call it before the rig is used for the recording.
/// @param source  name of the recording, for messages. @param size  of its images.
/// @return what was scaled; nothing where the sizes are equal.
/// @throws InputError when the rig does not have the camera, or the ratio of width to height
///   differs by more than the rounding of a side to an even number.
std::optional<CameraScaling> FitUpCamera(Rig& rig, const std::string& source, cv::Size size);
std::optional<CameraScaling> FitForwardCamera(Rig& rig, const std::string& source, cv::Size size);
std::optional<CameraScaling> FitOmniCamera(Rig& rig, const std::string& source, cv::Size size);

}  // namespace ceilmap::calib
