#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>

namespace ceilmap::calib {

/// Whether the optical axis is within 45 deg of straight up, and of base's x axis.
bool PointsUp(const Eigen::Matrix3d& R_base_cam);
bool PointsAhead(const Eigen::Matrix3d& R_base_cam);

/// Recognizes how the rotation of a camera that looks in a wrong direction was probably meant.
/// @param R_base_cam as read. @param looks_right whether a rotation is one of such a camera.
/// @return the slip with its remedy, as the end of a message; empty: none is recognized.
std::string RotationSlip(const Eigen::Matrix3d& R_base_cam,
                         const std::function<bool(const Eigen::Matrix3d&)>& looks_right);

}  // namespace ceilmap::calib
