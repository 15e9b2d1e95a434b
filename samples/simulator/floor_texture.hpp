#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace ceilmap::simulator {

/// Smooth noise over the floor on scales of 3 cm, 13 cm and half a metre, with mean 0 and standard
/// deviation 1 at close range; the scales repeat every 2, 8 and 32 m.
class FloorTexture {
 public:
  explicit FloorTexture(std::uint64_t seed);

  /// @param footprint_m  The longer side of a pixel's footprint on the floor. Finer scales are
  /// attenuated to avoid aliasing.
  [[nodiscard]] float At(double x_m, double y_m, double footprint_m) const;

 private:
  std::array<cv::Mat, 3> scales_;  // CV_32FC1
};

}  // namespace ceilmap::simulator
