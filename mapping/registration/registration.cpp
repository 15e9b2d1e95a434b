#include "mapping/registration/registration.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "calib/base/pose2.hpp"

namespace ceilmap::registration {

Eigen::Vector2d ImageMotion::Apply(const Eigen::Vector2d& x_centred) const {
  const double c = scale * std::cos(theta_rad);
  const double s = scale * std::sin(theta_rad);
  return {c * x_centred.x() - s * x_centred.y() + tx_px,
          s * x_centred.x() + c * x_centred.y() + ty_px};
}

ImageMotion ImageMotion::Inverse() const {
  ImageMotion inverse{0, 0, WrapAngle(-theta_rad), 1 / scale};
  const Eigen::Vector2d t = inverse.Apply({tx_px, ty_px});
  inverse.tx_px = -t.x();
  inverse.ty_px = -t.y();
  return inverse;
}

ImageMotion Compose(const ImageMotion& second, const ImageMotion& first) {
  const Eigen::Vector2d t = second.Apply({first.tx_px, first.ty_px});
  return {t.x(), t.y(), WrapAngle(second.theta_rad + first.theta_rad), second.scale * first.scale};
}

double OverlapOf(const ImageMotion& motion, cv::Size size) {
  constexpr int kSamples = 24;
  int seen = 0;
  for (int j = 0; j < kSamples; ++j) {
    for (int i = 0; i < kSamples; ++i) {
      const Eigen::Vector2d x(((i + 0.5) / kSamples - 0.5) * size.width,
                              ((j + 0.5) / kSamples - 0.5) * size.height);
      const Eigen::Vector2d y = motion.Apply(x);
      if (std::abs(y.x()) < 0.5 * size.width && std::abs(y.y()) < 0.5 * size.height) ++seen;
    }
  }
  return static_cast<double>(seen) / (kSamples * kSamples);
}

double Dissimilarity::Quantile(double fraction) const {
  std::vector<float> compared;
  std::copy_if(by_block.begin(), by_block.end(), std::back_inserter(compared), [](float nats) {
    return nats >= 0;
  });
  if (compared.empty()) return std::numeric_limits<double>::infinity();
  const double last = static_cast<double>(compared.size()) - 1;
  const auto at = compared.begin() + static_cast<std::ptrdiff_t>(std::lround(fraction * last));
  std::nth_element(compared.begin(), at, compared.end());
  return *at;
}

double Evidence(const Dissimilarity& a, const Dissimilarity& b) {
  constexpr double kEveryday = 0.7;  // nats by which blocks differ without other content
  double evidence = 0;
  for (std::size_t i = 0; i < std::min(a.by_block.size(), b.by_block.size()); ++i) {
    if (a.by_block[i] < 0 || b.by_block[i] < 0) continue;
    const double difference = b.by_block[i] - a.by_block[i];
    if (std::abs(difference) > kEveryday) evidence += difference;
  }
  return evidence;
}

}  // namespace ceilmap::registration
