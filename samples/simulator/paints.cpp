#include "samples/simulator/paints.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "samples/simulator/random.hpp"
#include "samples/simulator/room_surfaces.hpp"

namespace ceilmap::simulator {
namespace {

/// Grey 1 with a colour difference of the given size: red and blue minus the luminance, with the
/// green that keeps the luminance (Rec. 709).
cv::Vec3f Tint(double hue_rad, double size) {
  const double blue = 1.8556 * size * std::cos(hue_rad);
  const double red = 1.5748 * size * std::sin(hue_rad);
  const double green = -(0.2126 * red + 0.0722 * blue) / 0.7152;
  return {static_cast<float>(1 + blue), static_cast<float>(1 + green), static_cast<float>(1 + red)};
}

std::vector<cv::Vec3f> Tints(std::size_t count, double least, double most, Random& random) {
  std::vector<cv::Vec3f> tints;
  for (std::size_t i = 0; i < count; ++i) {
    const double hue_rad = random.Uniform(0, 2 * std::numbers::pi);
    tints.push_back(Tint(hue_rad, random.Uniform(least, most)));
  }
  return tints;
}

}  // namespace

double Luminance(double red, double green, double blue) {
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
}

Paints::Paints(std::uint64_t seed, std::size_t solids, double saturation) {
  Random random(seed, Purpose::kPaints);
  hull_ = Tints(kSolids, 0.02 * saturation, 0.06 * saturation, random);
  for (const std::size_t colourless : {kCeiling, kNothing, kRobot}) hull_[colourless] = {1, 1, 1};
  posters_ = Tints(kHues, 0.1 * saturation, 0.5 * saturation, random);
  solids_ = Tints(
      std::clamp<std::size_t>(solids, 1, kMaxSolids), 0.05 * saturation, 0.4 * saturation, random);
}

const cv::Vec3f& Paints::Of(std::uint16_t surface) const {
  if (surface < kSolids) return hull_[surface];
  if (surface < kPosters) return solids_[((surface - kSolids) / 6U) % solids_.size()];
  return posters_[Mix(surface) % kHues];
}

}  // namespace ceilmap::simulator
