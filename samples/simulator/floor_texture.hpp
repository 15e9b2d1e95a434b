#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace ceilmap::simulator {

/// Smooth noise over the floor on scales of 3 cm, 13 cm and half a metre, mean 0 and standard
/// deviation 1 from near; the scales repeat every 2, 8 and 32 m.
class FloorTexture {
 public:
  explicit FloorTexture(std::uint64_t seed);

  /// @param footprint_m  the longer side of what a pixel shows of the floor there. Scales finer
  /// than
  ///   that fade away instead of turning into false patterns.
  [[nodiscard]] float At(double x_m, double y_m, double footprint_m) const;

 private:
  std::array<cv::Mat, 3> scales_;  // CV_32FC1
};

}  // namespace ceilmap::simulator
