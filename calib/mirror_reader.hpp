#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/yaml_value.hpp"
#include "calib/mirror.hpp"

namespace ceilmap::calib {

/// Reads `mirror` of a camera of type hyperbolic_mirror in rig.yaml. @throws InputError also when
/// C^2 = A^2 + B^2 does not hold, or the viewpoint is not where T_base_cam and the mirror put it
/// (both to 1e-3).
HyperbolicMirror ParseMirror(const YamlValue& mirror, const Eigen::Isometry3d& T_base_cam);

/// Reads `mirror` of a camera of type mirror: the ring of its image that is of use.
/// @param image  size of its images, which must hold the outer circle.
/// @param axis_px  where the camera looks along its axis; the ring's centre unless it names one.
/// @throws InputError also when neither is known.
MirrorRing ParseMirrorRing(const YamlValue& mirror,
                           cv::Size image,
                           const std::optional<Eigen::Vector2d>& axis_px);

}  // namespace ceilmap::calib
