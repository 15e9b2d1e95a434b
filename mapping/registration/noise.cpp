#include "mapping/registration/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "mapping/registration/encoding.hpp"

namespace ceilmap::registration {
namespace {

// The codec's error where no white noise is left, grey levels.
constexpr float kCodingNoise = 5;
// ImageNoise::removed from which on it counts against a map: x264 at CRF 31. With less, images are
// registered with a map as those of any camera.
constexpr float kCoarse = 0.45F;

}  // namespace

ImageNoise ImageNoise::Reduced(double factor) const {
  const auto divisor = static_cast<float>(factor);
  return {white / divisor, coded / divisor, removed, removed_as_taken, predicted};
}

float EstimateNoise(const cv::Mat& grey) {
  // Mixed second difference: zero on planes and straight axis-parallel edges; its standard
  // deviation is 2 sigma.
  std::array<int, 1021> histogram{};
  int count = 0;
  int all = 0;
  for (int y = 0; y + 1 < grey.rows; y += 4) {
    const auto* a = grey.ptr<unsigned char>(y);
    const auto* b = grey.ptr<unsigned char>(y + 1);
    for (int x = 0; x + 1 < grey.cols; x += 3) {
      ++all;
      if (a[x] >= 250 || a[x] <= 2) continue;
      ++histogram[static_cast<std::size_t>(std::abs(a[x] - a[x + 1] - b[x] + b[x + 1]))];
      ++count;
    }
  }
  constexpr float kRounding = 0.3F;
  // In an image that is mostly black or white, the remaining grey values are edges of objects.
  constexpr int kMaxLost = 4;
  if (kMaxLost * count <= all) return kRounding;
  // Position of the median inside its bin by linear interpolation, because the differences are
  // whole grey levels.
  int below = 0;
  std::size_t bin = 0;
  while (below + histogram[bin] < (count + 1) / 2) below += histogram[bin++];
  const float inside = (0.5F * static_cast<float>(count) - static_cast<float>(below)) /
                       static_cast<float>(std::max(histogram[bin], 1));
  const float median = bin == 0 ? 0.5F * inside : static_cast<float>(bin) - 0.5F + inside;
  return std::max(kRounding, median / (2 * 0.6745F));
}

ImageNoise MakeNoise(float white, float sensor) {
  const float removed = std::max(0.0F, 1 - white / sensor);
  return {white, std::hypot(white, kCodingNoise * removed), removed, removed};
}

double LossAsTaken(const cv::Mat& grey) {
  return MakeNoise(EstimateNoise(grey)).removed;
}

double WhitePower(const ImageNoise& a, const ImageNoise& b) {
  return double{a.white} * b.white;
}

bool CodecCounts(const ImageNoise& reference, const ImageNoise& current, bool same_recording) {
  if (same_recording) return reference.IsEncoded() && current.IsEncoded();
  return current.predicted && current.removed_as_taken > kCoarse;
}

bool SmoothingCounts(const ImageNoise& reference, const ImageNoise& current, bool same_recording) {
  if (same_recording) return reference.IsSmooth() && current.IsSmooth();
  return current.predicted && current.removed > kCoarse;
}

double CodedPower(const ImageNoise& reference, const ImageNoise& current, bool same_recording) {
  if (!SmoothingCounts(reference, current, same_recording)) return WhitePower(reference, current);
  return double{same_recording ? reference.coded : current.coded} * current.coded;
}

double CommonPower(const ImageNoise& reference, const ImageNoise& current, bool same_recording) {
  if (!same_recording || CodecCounts(reference, current, same_recording)) {
    return CodedPower(reference, current, same_recording);
  }
  const ImageNoise& sharper = reference.removed < current.removed ? reference : current;
  return CodedPower(sharper, sharper, same_recording);
}

}  // namespace ceilmap::registration
