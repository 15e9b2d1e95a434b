#pragma once

#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/base/yaml_value.hpp"
#include "calib/lens.hpp"

namespace ceilmap::calib {

/// Intrinsics in the form of a ROS camera_info file (camera_calibration, camera_info_manager).
/// rectification_matrix and projection_matrix are checked for their form and not used: they
/// describe the rectified image of a stereo pair.
///
/// @throws InputError naming file, line, key and the fix.
Lens ReadCameraInfo(const std::filesystem::path& file);

/// The same from a file's text. @param file  its name in messages.
Lens ParseCameraInfo(const std::string& text, const std::filesystem::path& file);

/// The same from a map of keys already read. The caller checks for unknown keys.
Lens ParseCameraInfo(const YamlValue& info);

/// Reads image_width, image_height and camera_name only; the focal lengths are 0.
Lens ParseImageSize(const YamlValue& info);

/// The content of a camera_info file.
struct CameraInfo {
  std::string name;
  Lens lens;
  /// fx, fy, cx, cy of the images that ROS rectifies: its projection_matrix.
  std::array<double, 4> rectified{};
  std::vector<std::string> remarks;  ///< comment lines at the top of the file
};

/// Writes the text of a camera_info file, readable by ROS's camera_calibration_parsers and by
/// ReadCameraInfo. All digits of the numbers are kept.
std::string FormatCameraInfo(const CameraInfo& info);

}  // namespace ceilmap::calib
