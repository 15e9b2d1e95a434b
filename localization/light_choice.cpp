#include "localization/light_choice.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ceilmap::localization {
namespace {

constexpr int kKnownVotes = 2;
constexpr int kMaxVotes = 3;  // so that a new light is noticed soon

/// Correlation coefficient over a mask; 0 without contrast.
double CorrelationOver(const cv::Mat& a, const cv::Mat& b, const cv::Mat& mask) {
  cv::Scalar mean_a;
  cv::Scalar mean_b;
  cv::Scalar sigma_a;
  cv::Scalar sigma_b;
  cv::meanStdDev(a, mean_a, sigma_a, mask);
  cv::meanStdDev(b, mean_b, sigma_b, mask);
  const double spread = sigma_a[0] * sigma_b[0];
  if (!(spread > 0)) return 0;
  cv::Mat product;
  cv::multiply(a, b, product, 1, CV_32F);
  return (cv::mean(product, mask)[0] - mean_a[0] * mean_b[0]) / spread;
}

}  // namespace

bool LightChoice::IsKnown() const {
  return std::abs(votes_) >= kKnownVotes;
}

void LightChoice::Add(const cv::Mat& image,
                      const cv::Mat& in_map_light,
                      const cv::Mat& in_other_light,
                      const cv::Mat& content) {
  constexpr double kMinDifference = 20;  // grey levels
  constexpr double kMinRatio = 0.003;    // of the pixels
  constexpr double kMinCorrelation = 0.3;
  constexpr double kClear = 0.2;  // difference of the correlations
  constexpr int kAroundPx = 7;
  cv::Mat differ;
  cv::absdiff(in_map_light, in_other_light, differ);
  differ = (differ > kMinDifference) & content;
  if (cv::countNonZero(differ) < kMinRatio * static_cast<double>(differ.total())) return;
  const int side = 2 * kAroundPx + 1;
  cv::dilate(differ, differ, cv::Mat::ones(side, side, CV_8U));
  differ &= content;
  const double map = CorrelationOver(image, in_map_light, differ);
  const double other = CorrelationOver(image, in_other_light, differ);
  if (std::max(map, other) < kMinCorrelation || std::abs(other - map) < kClear) return;
  votes_ = std::clamp(votes_ + (other > map ? 1 : -1), -kMaxVotes, kMaxVotes);
}

}  // namespace ceilmap::localization
