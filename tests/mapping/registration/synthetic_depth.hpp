#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>

#include "mapping/registration/registration.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration::synthetic {

/// A ceiling with two heights, exact under any motion of a level camera: the reference plane, and
/// opaque strips below it that hide part of it. The principal point is the centre of the image.
class SyntheticDepth {
 public:
  /// @param rho  inverse height ratio of the strips. @param share  part of the image that they
  /// cover.
  explicit SyntheticDepth(double rho, double share = 0.45, std::uint32_t seed = 3)
      : rho_(rho), share_(share), far_(Texture(seed)), near_(Texture(seed + 100)) {}

  /// Image in which a point of the reference plane that is at p in the image without motion appears
  /// at motion.Apply(p); a point of the strips at motion.Apply with rho times the shift.
  [[nodiscard]] cv::Mat Render(cv::Size size,
                               const ImageMotion& motion = {},
                               double noise_sigma = 1,
                               std::uint32_t noise_seed = 1) const {
    ImageMotion nearer = motion;
    nearer.tx_px *= rho_;
    nearer.ty_px *= rho_;
    return Render(size, motion, nearer, noise_sigma, noise_seed);
  }

  /// The same for a camera of any height and focal length. @param farther, nearer  motions of the
  /// reference plane and of the strips.
  [[nodiscard]] cv::Mat Render(cv::Size size,
                               const ImageMotion& farther,
                               const ImageMotion& nearer,
                               double noise_sigma,
                               std::uint32_t noise_seed) const {
    const cv::Mat far = far_.Render(size, farther, noise_sigma, 2 * noise_seed);
    cv::Mat image = near_.Render(size, nearer, noise_sigma, 2 * noise_seed + 1);
    const ImageMotion back = nearer.Inverse();
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const Eigen::Vector2d x(u - 0.5 * (size.width - 1), v - 0.5 * (size.height - 1));
        const double alpha = Cover(back.Apply(x));
        auto& pixel = image.at<std::uint8_t>(v, u);
        pixel = cv::saturate_cast<std::uint8_t>(alpha * pixel +
                                                (1 - alpha) * far.at<std::uint8_t>(v, u));
      }
    }
    return image;
  }

  /// Whether a strip covers this point of the image without motion, apart from the strips' borders.
  [[nodiscard]] double Cover(const Eigen::Vector2d& p) const {
    constexpr double kPeriod = 150;
    const double at = p.x() + 0.35 * p.y();
    const double off = std::abs(at - kPeriod * std::round(at / kPeriod));
    return std::clamp(0.5 * share_ * kPeriod - off + 0.5, 0.0, 1.0);
  }

 private:
  static CeilingParams Texture(std::uint32_t seed) {
    CeilingParams params;
    params.seed = seed;
    params.tile_px = 0;
    params.lamps = false;
    return params;
  }

  double rho_;
  double share_;
  SyntheticCeiling far_;
  SyntheticCeiling near_;
};

}  // namespace ceilmap::registration::synthetic
