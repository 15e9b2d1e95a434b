#include "samples/simulator/wall_texture.hpp"

#include <numbers>

#include "samples/simulator/noise.hpp"
#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

constexpr int kSize = 512;        // a power of two
constexpr double kPitch = 0.008;  // metres

}  // namespace

WallTexture::WallTexture(std::uint64_t seed) : samples_(kSize, kSize, CV_32FC1, cv::Scalar(0)) {
  const SampleGrid grid{0, 0, kPitch, kPitch, kSize, kSize};
  const std::uint64_t key = Random(seed, Purpose::kWalls).Bits();
  std::uint64_t scale = 0;
  for (const int cells : {8, 32, 128}) {
    AddSplineNoise(
        Mix(key + ++scale), kSize * kPitch / cells, 1 / std::numbers::sqrt3, grid, samples_, cells);
  }
}

float WallTexture::At(double x_m, double y_m) const {
  constexpr double kPeriods = 1 << 20;  // to count from 0: truncation then is the floor
  const double x = x_m / kPitch + kPeriods;
  const double y = y_m / kPitch + kPeriods;
  const int u = static_cast<int>(x);
  const int v = static_cast<int>(y);
  const auto part_x = static_cast<float>(x - u);
  const auto part_y = static_cast<float>(y - v);
  constexpr int kMask = kSize - 1;
  const float* const data = samples_.ptr<float>();
  const float* const top = data + (v & kMask) * kSize;
  const float* const low = data + ((v + 1) & kMask) * kSize;
  const int left = u & kMask;
  const int right = (u + 1) & kMask;
  const float over = top[left] + part_x * (top[right] - top[left]);
  const float under = low[left] + part_x * (low[right] - low[left]);
  return over + part_y * (under - over);
}

}  // namespace ceilmap::simulator
