#include "samples/simulator/floor_texture.hpp"

#include <algorithm>
#include <numbers>

#include "samples/simulator/noise.hpp"
#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

constexpr std::array<double, 3> kCells{0.03125, 0.125, 0.5};  // metres
constexpr int kSamplesPerCell = 4;
constexpr int kPeriodCells = 64;
constexpr int kSize = kSamplesPerCell * kPeriodCells;  // a power of two

}  // namespace

FloorTexture::FloorTexture(std::uint64_t seed) {
  const std::uint64_t key = Random(seed, Purpose::kFloor).Bits();
  for (std::size_t i = 0; i < scales_.size(); ++i) {
    const double pitch_m = kCells.at(i) / kSamplesPerCell;
    cv::Mat& samples = scales_.at(i);
    samples = cv::Mat(kSize, kSize, CV_32FC1, cv::Scalar(0));
    AddSplineNoise(Mix(key + i),
                   kCells.at(i),
                   1 / std::numbers::sqrt3,
                   {0, 0, pitch_m, pitch_m, kSize, kSize},
                   samples,
                   kPeriodCells);
  }
}

float FloorTexture::At(double x_m, double y_m, double footprint_m) const {
  float sum = 0;
  for (std::size_t i = 0; i < scales_.size(); ++i) {
    const double share = std::clamp(2 - 2 * footprint_m / kCells.at(i), 0.0, 1.0);
    if (!(share > 0)) continue;
    const double per_m = kSamplesPerCell / kCells.at(i);
    sum += static_cast<float>(share) * SamplePeriodic(scales_.at(i), x_m * per_m, y_m * per_m);
  }
  return sum;
}

}  // namespace ceilmap::simulator
