#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Grey of a colour: Rec. 709, which is what a camera without colours sees of it.
double Luminance(double red, double green, double blue);

/// The colours of the room's surfaces, by the seed: walls, floor and ceiling nearly grey, each of
/// its own hue, boxes and what hangs on the walls coloured. Each colour has luminance 1 and so
/// leaves the light of a surface as it is.
class Paints {
 public:
  /// @param boxes  how many are painted by the seed. @param saturation  0: all grey.
  Paints(std::uint64_t seed, std::size_t boxes, double saturation);

  /// Light of unit luminance, blue, green, red. @param surface  as Surface in room_surfaces.hpp.
  [[nodiscard]] const cv::Vec3f& Of(std::uint16_t surface) const;

 private:
  static constexpr std::size_t kHues = 64;

  std::vector<cv::Vec3f> hull_;     // surfaces below kBoxes
  std::vector<cv::Vec3f> boxes_;    // hues
  std::vector<cv::Vec3f> posters_;  // hues
};

}  // namespace ceilmap::simulator
