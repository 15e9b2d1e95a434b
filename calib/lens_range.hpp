#pragma once

#include <optional>

#include "calib/camera.hpp"

namespace ceilmap::calib {

/// Inverse of the radial part of the lens model; the tangential part is left out.
/// @param distorted  distance from the optical axis in the image, in focal lengths, >= 0.
/// @return the tangent of the angle between the optical axis and the ray; nothing where the model
///   is not valid: its polynomial stops increasing before it reaches that distance.
std::optional<double> UndistortedRadius(const PinholeCamera& camera, double distorted);

/// The largest distance from the principal point that the image shows, in focal lengths.
double CornerRadius(const PinholeCamera& camera);

/// The largest distance, as a fraction of CornerRadius, at which the lens model is valid; 1 when it
/// is valid in the complete image.
double ValidRatio(const PinholeCamera& camera);

}  // namespace ceilmap::calib
