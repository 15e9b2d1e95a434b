#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace ceilmap::simulator {

/// Smooth noise over a plane on scales of 3 cm to half a metre, mean 0 and standard deviation 1;
/// repeats every 4 m.
class WallTexture {
 public:
  explicit WallTexture(std::uint64_t seed);

  [[nodiscard]] float At(double x_m, double y_m) const;

 private:
  cv::Mat samples_;  // CV_32FC1
};

}  // namespace ceilmap::simulator
