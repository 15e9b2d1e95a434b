#include "mapping/change/cell_comparison.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::change {
namespace {

// Texture: below the first share the looks are the same, above the second one others.
constexpr double kSameShare = 0.35;
constexpr double kOtherShare = 0.6;
// Brightness, log: uneven light stays below the first, another surface exceeds the second.
constexpr double kSameBrightness = 0.08;
constexpr double kOtherBrightness = 0.16;
// Contrast of texture relative to the mean, that uneven light does not have.
constexpr double kMinContrast = 0.012;

}  // namespace

CellSums SumsOver(const cv::Mat& a, const cv::Mat& b) {
  CellSums sums;
  for (int row = 0; row < a.rows; ++row) {
    const float* pa = a.ptr<float>(row);
    const float* pb = b.ptr<float>(row);
    float sum_a = 0;
    float sum_b = 0;
    float sum_aa = 0;
    float sum_bb = 0;
    float sum_ab = 0;
    for (int col = 0; col < a.cols; ++col) {
      sum_a += pa[col];
      sum_b += pb[col];
      sum_aa += pa[col] * pa[col];
      sum_bb += pb[col] * pb[col];
      sum_ab += pa[col] * pb[col];
    }
    sums.a += sum_a;
    sums.b += sum_b;
    sums.aa += sum_aa;
    sums.bb += sum_bb;
    sums.ab += sum_ab;
  }
  sums.pixels = static_cast<double>(a.total());
  return sums;
}

CellDifference Compare(const CellSums& sums, double noise) {
  const double mean_a = sums.MeanA();
  const double mean_b = sums.MeanB();
  const double var_a = std::max(0.0, sums.aa / sums.pixels - mean_a * mean_a);
  const double var_b = std::max(0.0, sums.bb / sums.pixels - mean_b * mean_b);
  const double cov = sums.ab / sums.pixels - mean_a * mean_b;
  CellDifference difference;
  difference.log_ratio = std::log(std::max(mean_b, 1.0) / std::max(mean_a, 1.0));
  const double signal = var_a + var_b - noise;
  const double contrast = kMinContrast * std::max(mean_a, mean_b);
  difference.textured = signal > std::max(2 * contrast * contrast, noise);
  if (signal > 0) {
    difference.share = std::clamp((var_a + var_b - 2 * cov - noise) / signal, 0.0, 1.0);
  }
  return difference;
}

CellState StateOf(const CellDifference& difference) {
  const double brightness = std::abs(difference.log_ratio);
  if (difference.textured) {
    if (difference.share > kOtherShare) return CellState::kTexture;
    // The same texture in another brightness is a shadow or a sun patch.
    return difference.share < kSameShare && brightness < kOtherBrightness ? CellState::kSame
                                                                          : CellState::kUnclear;
  }
  if (brightness > kOtherBrightness) return CellState::kBrightness;
  return brightness < kSameBrightness ? CellState::kSame : CellState::kUnclear;
}

}  // namespace ceilmap::change
