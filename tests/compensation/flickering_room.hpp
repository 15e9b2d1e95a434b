#pragma once

#include "samples/simulator/scene.hpp"

namespace ceilmap::compensation::synthetic {

/// A tiled ceiling under lamps that flicker, and a fisheye with a rolling shutter. At ten images a
/// second the bands stand still in the rows.
inline simulator::Scene FlickeringRoom() {
  simulator::Scene scene;
  scene.room.height_m = 2.8;
  scene.camera.width_px = 320;
  scene.camera.height_px = 240;
  scene.camera.focal_px = 160;
  scene.camera.distortion_model = calib::LensModel::kEquidistant;
  scene.camera.distortion = {-0.028, 0.0065, -0.0032, 0.0004};
  scene.camera.exposure_time_s = 0.004;
  scene.camera.readout_time_s = 0.025;
  scene.image.motion_blur = false;
  scene.path.acceleration_m_s2 = 3;
  return scene;
}

}  // namespace ceilmap::compensation::synthetic
