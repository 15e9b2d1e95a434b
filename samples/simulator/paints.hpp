#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Luminance of a colour: Rec. 709, as in a grey camera.
double Luminance(double red, double green, double blue);

/// The colours of the room's surfaces, by the seed: walls, floor and ceiling nearly grey, each with
/// its own hue, solids and posters coloured. Each colour has luminance 1, so that the light of a
/// surface is not changed.
class Paints {
 public:
  /// @param solids  Number of solids with random colours. @param saturation  0: all grey.
  Paints(std::uint64_t seed, std::size_t solids, double saturation);

  /// Light of unit luminance, blue, green, red. @param surface  As Surface in room_surfaces.hpp.
  [[nodiscard]] const cv::Vec3f& Of(std::uint16_t surface) const;

 private:
  static constexpr std::size_t kHues = 64;

  std::vector<cv::Vec3f> hull_;     // surfaces below kSolids
  std::vector<cv::Vec3f> solids_;   // hues
  std::vector<cv::Vec3f> posters_;  // hues
};

}  // namespace ceilmap::simulator
