#pragma once

#include <filesystem>

#include "calib/camera.hpp"
#include "calib/yaml_value.hpp"

namespace ceilmap::calib {

/// Intrinsics in the form of a ROS camera_info file (camera_calibration, camera_info_manager).
/// rectification_matrix and projection_matrix are checked for their form and not used: they
/// describe the rectified picture of a stereo pair.
///
/// @throws InputError naming file, line, key and the mend.
PinholeCamera ReadCameraInfo(const std::filesystem::path& file);

/// The same from a map of keys already read. The caller checks for unknown keys.
PinholeCamera ParseCameraInfo(const YamlValue& info);

/// Its image_width, image_height and camera_name alone; focal lengths 0.
PinholeCamera ParsePictureSize(const YamlValue& info);

}  // namespace ceilmap::calib
