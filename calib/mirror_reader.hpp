#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/yaml_value.hpp"
#include "calib/mirror.hpp"

namespace ceilmap::calib {

/// Reads `mirror` of a camera of type hyperbolic_mirror in rig.yaml. @throws InputError also when
/// C^2 = A^2 + B^2 does not hold, or the viewpoint differs from the one given by T_base_cam and the
/// mirror (tolerance 1e-3 each).
HyperbolicMirror ParseMirror(const YamlValue& mirror, const Eigen::Isometry3d& T_base_cam);

/// Reads `mirror` of a camera of type mirror: the usable ring of its image.
/// @param image size of its images, which must contain the outer circle.
/// @param axis_px pixel on the optical axis of the camera; it is the centre of the ring unless the
///   file gives one.
/// @throws InputError also when neither centre is known.
MirrorRing ParseMirrorRing(const YamlValue& mirror,
                           cv::Size image,
                           const std::optional<Eigen::Vector2d>& axis_px);

}  // namespace ceilmap::calib
