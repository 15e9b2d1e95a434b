#include "samples/simulator/wall_texture.hpp"

#include <numbers>

#include "samples/simulator/noise.hpp"
#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

constexpr int kSamples = 512;     // a power of two
constexpr double kPitch = 0.008;  // metres

}  // namespace

WallTexture::WallTexture(std::uint64_t seed)
    : samples_(kSamples, kSamples, CV_32FC1, cv::Scalar(0)) {
  const SampleGrid grid{0, 0, kPitch, kPitch, kSamples, kSamples};
  const std::uint64_t key = Random(seed, Purpose::kWalls).Bits();
  std::uint64_t scale = 0;
  for (const int cells : {8, 32, 128}) {
    AddSplineNoise(Mix(key + ++scale),
                   kSamples * kPitch / cells,
                   1 / std::numbers::sqrt3,
                   grid,
                   samples_,
                   cells);
  }
}

float WallTexture::At(double x_m, double y_m) const {
  return SamplePeriodic(samples_, x_m / kPitch, y_m / kPitch);
}

}  // namespace ceilmap::simulator
