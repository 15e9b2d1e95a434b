#pragma once

#include <stdexcept>
#include <string>

namespace ceilmap::calib {

/// A complete rig file with all cameras; the line numbers below are used by the tests.
inline const std::string kRigText = R"(robot: "robot 1"
a: 0.14
d: 0.45
h: 2.6
frames: {map: room, base: base_link}
cameras:
  up:
    type: pinhole
    image_width: 640
    image_height: 480
    camera_name: up
    camera_matrix: {rows: 3, cols: 3, data: [457.0, 0, 319.5, 0, 458.0, 239.5, 0, 0, 1]}
    distortion_model: plumb_bob
    distortion_coefficients: {rows: 1, cols: 5, data: [-0.12, 0.02, 0.001, -0.002, 0.003]}
    rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
    projection_matrix: {rows: 3, cols: 4, data: [457, 0, 319.5, 0, 0, 457, 239.5, 0, 0, 0, 1, 0]}
    base_link_to_camera:
      frame: up_optical_frame
      translation: [0.02, -0.01, 0.4]
      rotation_xyzw: [0, 0, 0.707106781, 0.707106781]
      matrix: [0, -1, 0, 0.02, 1, 0, 0, -0.01, 0, 0, 1, 0.4, 0, 0, 0, 1]
    exposure_time: 0.005
  forward:
    type: pinhole
    image_width: 320
    image_height: 240
    camera_matrix: {rows: 3, cols: 3, data: [277, 0, 159.5, 0, 277, 119.5, 0, 0, 1]}
    distortion_model: none
    base_link_to_camera:
      translation: [0, 0, 0.45]
      rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]
  omni:
    type: hyperbolic_mirror
    image_width: 480
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [520, 0, 239.5, 0, 520, 239.5, 0, 0, 1]}
    distortion_model: ""
    distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
    base_link_to_camera:
      matrix: [0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.55, 0, 0, 0, 1]
    mirror:
      A: 0.028095
      B: 0.0234125
      C: 0.0365714941
      rim_radius: 0.04
      base_link_to_viewpoint: [0, 0, 0.623142988]
      rim_radius_px: 225.623
      horizon_radius_px: 138.707
)";

/// The shortest rig of a ceiling map.
inline const std::string kMinimalRigText = R"(h: 2.6
cameras:
  up:
    type: pinhole
    image_width: 640
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [457, 0, 319.5, 0, 457, 239.5, 0, 0, 1]}
    base_link_to_camera: {translation: [0, 0, 0.4]}
)";

/// The text with its first `from` replaced. @throws std::logic_error when there is none.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("no such text: " + from);
  return text.replace(at, from.size(), to);
}

}  // namespace ceilmap::calib
