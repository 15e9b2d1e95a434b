#include "mapping/change/cell_comparison.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::change {
namespace {

// Brightness, log: noise and uneven light stay below the first, another surface exceeds the second.
constexpr double kSameBrightness = 0.008;
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

double CellDifference::Share() const {
  return signal > 0 ? std::clamp(other / signal, 0.0, 1.0) : 0;
}

CellDifference Compare(const CellSums& sums, double noise) {
  const double mean_a = std::max(sums.MeanA(), 1.0);
  const double mean_b = std::max(sums.MeanB(), 1.0);
  const double gain = mean_a / mean_b;
  const double var_a = std::max(0.0, sums.aa / sums.pixels - sums.MeanA() * sums.MeanA());
  const double var_b =
      gain * gain * std::max(0.0, sums.bb / sums.pixels - sums.MeanB() * sums.MeanB());
  const double cov = gain * (sums.ab / sums.pixels - sums.MeanA() * sums.MeanB());
  return {-std::log(gain), var_a + var_b - noise, var_a + var_b - 2 * cov - noise};
}

bool IsTextured(const CellDifference& difference, double mean, double noise) {
  const double contrast = kMinContrast * mean;
  return difference.signal > std::max(2 * contrast * contrast, 2 * noise);
}

CellState StateOf(const CellDifference& difference, double mean, double noise) {
  const double brightness = std::abs(difference.log_ratio);
  if (IsTextured(difference, mean, noise)) {
    if (difference.Share() > kOtherShare) return CellState::kTexture;
    // The same texture in another brightness is a shadow or a sun patch, or the joints of a tile
    // that was replaced.
    return difference.Share() < kSameShare && brightness < kSameBrightness ? CellState::kSame
                                                                           : CellState::kUnclear;
  }
  if (brightness > kOtherBrightness) return CellState::kBrightness;
  return brightness < kSameBrightness && difference.other < noise ? CellState::kSame
                                                                  : CellState::kUnclear;
}

}  // namespace ceilmap::change
