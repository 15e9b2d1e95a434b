#include "samples/simulator/auto_exposure.hpp"

#include <algorithm>
#include <cmath>

#include "samples/simulator/image_model.hpp"
#include "samples/simulator/renderer.hpp"

namespace ceilmap::simulator {
namespace {

constexpr int kShrink = 8;
constexpr double kMaxGain = 32;     // of a camera, in both directions
constexpr double kMinLight = 1e-4;  // where an image is black

/// The scene with an upward camera of an eighth of the size, and nothing but it.
Scene SmallScene(Scene scene) {
  constexpr int kMinSide = 16;
  scene.camera.width_px = std::max(kMinSide, scene.camera.width_px / kShrink);
  scene.camera.height_px = std::max(kMinSide, scene.camera.height_px / kShrink);
  scene.camera.focal_px = std::max(8.0, scene.camera.focal_px / kShrink);
  scene.camera.readout_time_s = 0;
  scene.forward.reset();
  scene.omni.reset();
  return scene;
}

}  // namespace

void FollowExposure(const Scene& scene, std::vector<Frame>& frames) {
  const double lag_s = scene.image.auto_exposure_lag_s;
  if (lag_s == 0 || frames.empty()) return;
  const Scene small = SmallScene(scene);
  const Renderer renderer(small);
  const ImageModel camera(small, small.camera, {});
  const auto mean_of = [&](const Frame& frame) {
    const cv::Mat seen = cv::min(renderer.RenderLight(frame.T_map_base) * camera.Gain(frame), 1);
    return std::max(cv::mean(seen)[0], kMinLight);
  };
  const double target = mean_of(frames.front());
  double gain = 1;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (i > 0) {
      const double passed_s = frames[i].stamp_s - frames[i - 1].stamp_s;
      const double share = 1 - std::exp(-passed_s / lag_s);
      gain *= std::pow(target / mean_of(frames[i - 1]), share);
      gain = std::clamp(gain, 1 / kMaxGain, kMaxGain);
    }
    frames[i].auto_gain = gain;
  }
}

}  // namespace ceilmap::simulator
