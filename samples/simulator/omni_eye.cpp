#include "samples/simulator/omni_eye.hpp"

#include <utility>

#include "samples/simulator/movers.hpp"

namespace ceilmap::simulator {
namespace {

ImageModel ColourModel(const Scene& scene, PixelPurposes purposes) {
  Scene of_omni = scene;
  of_omni.image.exposure_gain = scene.omni->exposure_gain;
  of_omni.image.exposure_steps = scene.omni->exposure_steps;
  Camera camera;
  camera.width_px = scene.omni->width_px;
  camera.height_px = scene.omni->height_px;
  camera.exposure_time_s = 0;
  return {of_omni, camera, purposes};
}

}  // namespace

OmniEye::OmniEye(const Scene& scene, std::vector<Solid> solids)
    : scene_(scene),
      tracer_(scene, std::move(solids)),
      colours_{ColourModel(scene, {Purpose::kOmniBlueGain, Purpose::kOmniBlueNoise, -1}),
               ColourModel(scene, {Purpose::kOmniGreenGain, Purpose::kOmniGreenNoise}),
               ColourModel(scene, {Purpose::kOmniRedGain, Purpose::kOmniRedNoise, 1})} {}

cv::Mat OmniEye::Light(const Frame& frame) const {
  return tracer_.Trace(frame.T_map_base, MoversAt(scene_, frame.stamp_s));
}

cv::Mat OmniEye::Take(const Frame& frame) const {
  return DevelopPlanes(colours_, Light(frame), frame);
}

}  // namespace ceilmap::simulator
