#include "localization/compass/colour/white_balance.hpp"

#include <algorithm>
#include <cstddef>

namespace ceilmap::colour {
namespace {

/// The inverse of cv::COLOR_BGR2YUV without rounding.
cv::Scalar ToBgr(const std::array<double, 3>& yuv) {
  const double u = yuv[1] - 128;
  const double v = yuv[2] - 128;
  return {yuv[0] + 2.032 * u, yuv[0] - 0.395 * u - 0.581 * v, yuv[0] + 1.140 * v};
}

}  // namespace

WhiteBalance::WhiteBalance(const std::vector<ColourClass>& classes) {
  std::array<double, 3> mean{};
  double weights = 0;
  for (const ColourClass& one : classes) {
    weights += double{one.weight};
    for (std::size_t c = 0; c < 3; ++c) mean[c] += double{one.weight} * double{one.mean[c]};
  }
  for (double& channel : mean) channel /= weights;
  model_ = ToBgr(mean);
}

void WhiteBalance::Add(const cv::Mat& samples, const ScanLines& lines) {
  for (int i = 0; i < samples.rows; ++i) {
    const int length = lines.Length(static_cast<std::size_t>(i));
    sum_ += cv::sum(samples.row(i).colRange(0, length));
    count_ += length;
  }
}

ChannelGains WhiteBalance::Gains() const {
  ChannelGains gains{1, 1, 1};
  constexpr double kMax = 3;
  for (int c = 0; c < 3; ++c) {
    if (!(sum_[c] > 0)) continue;
    gains[static_cast<std::size_t>(c)] = std::clamp(model_[c] * count_ / sum_[c], 1 / kMax, kMax);
  }
  return gains;
}

void Apply(const ChannelGains& gains, cv::Mat& bgr) {
  cv::Mat table(1, 256, CV_8UC3);
  constexpr int kSaturated = 250;
  for (int level = 0; level < 256; ++level) {
    for (int c = 0; c < 3; ++c) {
      table.at<cv::Vec3b>(level)[c] =
          level >= kSaturated
              ? cv::saturate_cast<uchar>(255)
              : cv::saturate_cast<uchar>(gains[static_cast<std::size_t>(c)] * level);
    }
  }
  cv::LUT(bgr, table, bgr);
}

}  // namespace ceilmap::colour
