#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calib/rig.hpp"

namespace ceilmap_ros {

/// The content of a sensor_msgs/CameraInfo.
struct CameraFacts {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};    ///< all zero: the camera is not calibrated
  std::uint32_t binning_x = 0;  ///< 0 and 1: none
  std::uint32_t binning_y = 0;
  bool region_of_interest = false;  ///< the images are cropped

  [[nodiscard]] bool Calibrated() const { return k[0] > 0; }
  bool operator==(const CameraFacts&) const = default;
};

/// The lens of the images that the camera sends.
/// @throws InputError on a model or values that ceilmap does not have, and for cropped images.
ceilmap::calib::Lens LensOf(const CameraFacts& camera);

/// Compares the calibration that a driver publishes with that of the rig, at points over the whole
/// image.
/// @return one line where they differ by more than 1 % of the image's width; nothing where they
///   agree, or when the driver publishes none.
std::optional<std::string> Mismatch(const ceilmap::calib::Lens& rig, const CameraFacts& camera);

}  // namespace ceilmap_ros
