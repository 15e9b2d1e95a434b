#include "mapping/registration/content_centres.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ceilmap::registration {

namespace {

constexpr double kBlurPx = 1;
// Squared gradients of noise are distributed exponentially: few exceed this number of medians.
constexpr double kNoiseMedians = 6;

double MedianOf(const cv::Mat& values) {
  std::vector<float> all(values.begin<float>(), values.end<float>());
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

double SumOf(const cv::Mat& integral, const cv::Rect& part) {
  const auto at = [&](int y, int x) { return integral.at<double>(y, x); };
  const cv::Point end = part.br();
  return at(end.y, end.x) - at(part.y, end.x) - at(end.y, part.x) + at(part.y, part.x);
}

}  // namespace

ContentCentres::ContentCentres(const cv::Mat& grey) : size_(grey.size()) {
  cv::Mat smooth;
  cv::Mat along_x;
  cv::Mat along_y;
  cv::GaussianBlur(grey, smooth, {}, kBlurPx);
  cv::Sobel(smooth, along_x, CV_32F, 1, 0);
  cv::Sobel(smooth, along_y, CV_32F, 0, 1);
  cv::Mat weight = along_x.mul(along_x) + along_y.mul(along_y);
  const double median = MedianOf(weight);
  weight = cv::max(weight - kNoiseMedians * median, 0);
  // What noise leaves there, and a little where there is none.
  constexpr double kChanceMedians = 0.1;
  constexpr double kMin = 1e-3;
  chance_ = kChanceMedians * median + kMin;
  cv::Mat columns(1, size_.width, CV_32FC1);
  cv::Mat rows(size_.height, 1, CV_32FC1);
  for (int x = 0; x < size_.width; ++x) columns.at<float>(0, x) = static_cast<float>(x);
  for (int y = 0; y < size_.height; ++y) rows.at<float>(y, 0) = static_cast<float>(y);
  cv::integral(weight, weight_, CV_64F);
  cv::integral(weight.mul(cv::repeat(columns, size_.height, 1)), weighted_x_, CV_64F);
  cv::integral(weight.mul(cv::repeat(rows, 1, size_.width)), weighted_y_, CV_64F);
}

Eigen::Vector2d ContentCentres::Of(const cv::Rect& part) const {
  const Eigen::Vector2d middle(part.x + 0.5 * (part.width - 1), part.y + 0.5 * (part.height - 1));
  const double chance = chance_ * part.area();
  const Eigen::Vector2d sum(SumOf(weighted_x_, part), SumOf(weighted_y_, part));
  const Eigen::Vector2d at = (sum + chance * middle) / (SumOf(weight_, part) + chance);
  return at - 0.5 * Eigen::Vector2d(size_.width - 1, size_.height - 1);
}

}  // namespace ceilmap::registration
