#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/core.hpp>

#include "calib/base/degrees.hpp"
#include "samples/simulator/renderer.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A room of 12 x 8 x 2.4 m with an even ceiling of light 0.4 and a camera at 0.4 m that spans 2 m
/// / 400 px = 5 mm a pixel there. Its image is the light itself, but for the sRGB curve.
inline Scene PlainScene() {
  Scene scene;
  scene.room.height_m = 2.4;
  scene.ceiling.kind = CeilingKind::kUniform;
  scene.camera.width_px = 320;
  scene.camera.height_px = 240;
  scene.camera.focal_px = 400;
  scene.fixtures.contrast = 0;
  scene.image.motion_blur = false;
  scene.image.blur_px = 0;
  scene.image.glare = 0;
  scene.image.vignetting = 0;
  scene.image.shot_noise = 0;
  scene.image.read_noise = 0;
  scene.image.gain_spread = 0;
  return scene;
}

/// That room without any light of its own: only what is put into it shows.
inline Scene DarkScene() {
  Scene scene = PlainScene();
  scene.ceiling.brightness = 0;
  scene.room.wall_brightness = 0;
  scene.room.wall_contrast = 0;
  scene.room.floor_brightness = 0;
  return scene;
}

inline Eigen::Isometry3d Level(double x_m, double y_m, double yaw_deg) {
  return StillFrame(0, {x_m, y_m, yaw_deg * kRadPerDeg}).T_map_base;
}

/// Pixel that shows a point of the map, by the rig's own camera model.
inline Eigen::Vector2d Pixel(const Renderer& renderer,
                             const Eigen::Isometry3d& T_map_base,
                             const Eigen::Vector3d& p_map) {
  const calib::MountedCamera& up = *renderer.GetRig().up;
  return *up.camera.Project((T_map_base * up.T_base_cam).inverse() * p_map);
}

/// Centre of what differs from the even ceiling, weighted by how much.
inline Eigen::Vector2d CentreOfMark(const cv::Mat& light, double ceiling = 0.4) {
  double sum = 0;
  Eigen::Vector2d moment(0, 0);
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) {
      const double weight = std::abs(light.at<float>(v, u) - ceiling);
      if (weight < 1e-3) continue;  // the texture's 16 bits
      sum += weight;
      moment += weight * Eigen::Vector2d(u, v);
    }
  }
  return moment / sum;
}

}  // namespace ceilmap::simulator
