#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/image_model.hpp"
#include "samples/simulator/omni_tracer.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The camera under the mirror with everything its images need. Thread-safe.
class OmniEye {
 public:
  /// @param scene  Valid, with an omni camera.
  OmniEye(const Scene& scene, std::vector<Solid> solids);

  /// The light on the pixels: CV_32FC3, blue, green, red, 1 = white.
  [[nodiscard]] cv::Mat Light(const Frame& frame) const;
  /// The image: CV_8UC3, blue, green, red. The noise is independent per colour.
  [[nodiscard]] cv::Mat Take(const Frame& frame) const;

 private:
  Scene scene_;
  OmniTracer tracer_;
  std::array<ImageModel, 3> colours_;  // blue, green, red
};

}  // namespace ceilmap::simulator
