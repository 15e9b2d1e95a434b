#include "mapping/change/brightness_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calib/base/statistics.hpp"

namespace ceilmap::change {

BrightnessFit::Terms BrightnessFit::TermsAt(const cv::Point2d& at) const {
  const double x = (at.x - centre_.x) * scale_;
  const double y = (at.y - centre_.y) * scale_;
  return (Terms() << 1, x, y, x * x, x * y, y * y).finished();
}

BrightnessFit::BrightnessFit(const std::vector<Sample>& samples, const cv::Rect2d& extent)
    : centre_((extent.tl() + extent.br()) / 2), scale_(2 / std::max(extent.width, extent.height)) {
  constexpr std::size_t kMinSamples = 12;
  if (samples.empty()) return;
  std::vector<double> values;
  values.reserve(samples.size());
  for (const Sample& sample : samples) values.push_back(sample.log_ratio);
  weights_[0] = Median(values);
  if (samples.size() < kMinSamples) return;
  // Least absolute deviations lead close enough for Tukey's weights, which forget what deviates.
  constexpr int kAbsoluteIterations = 8;
  constexpr int kIterations = 13;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      values[i] = std::abs(samples[i].log_ratio - LogRatio(samples[i].at));
    }
    constexpr double kMinSigma = 0.01;
    constexpr double kTukeySigmas = 4.7;
    const double limit = kTukeySigmas * std::max(kMinSigma, 1.4826 * Median(values));
    Eigen::Matrix<double, 6, 6> normal = 1e-3 * Eigen::Matrix<double, 6, 6>::Identity();
    Terms right = Terms::Zero();
    for (const Sample& sample : samples) {
      const double deviation = std::abs(sample.log_ratio - LogRatio(sample.at));
      const bool absolute = iteration < kAbsoluteIterations;
      if (!absolute && deviation >= limit) continue;
      const double weight = absolute ? kMinSigma / std::max(deviation, kMinSigma)
                                     : std::pow(1 - std::pow(deviation / limit, 2), 2);
      const Terms terms = TermsAt(sample.at);
      normal += weight * terms * terms.transpose();
      right += weight * sample.log_ratio * terms;
    }
    weights_ = normal.ldlt().solve(right);
  }
}

double BrightnessFit::LogRatio(const cv::Point2d& at) const {
  return weights_.dot(TermsAt(at));
}

}  // namespace ceilmap::change
