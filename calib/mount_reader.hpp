#pragma once

#include <Eigen/Geometry>

#include "calib/base/yaml_value.hpp"

namespace ceilmap::calib {

/// Reads `base_link_to_camera` of rig.yaml (T_base_cam: p_base = R p_cam + t): translation and
/// rotation_xyzw, or a 4 x 4 matrix, or both when they agree to 1e-3 (rad, m). Rounded rotations
/// (errors up to 1e-3) are made orthonormal.
/// @param R_default  the rotation when none is given.
/// @throws InputError
Eigen::Isometry3d ParseCameraPose(const YamlValue& pose, const Eigen::Matrix3d& R_default);

}  // namespace ceilmap::calib
