#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <vector>

#include "mapping/registration/registration.hpp"

namespace ceilmap::registration::synthetic {

/// An even ceiling with a few weak, large structures, whose contrast is below the noise of a pixel.
/// Drawn from formulas, as SyntheticCeiling.
class PlainCeiling {
 public:
  struct Params {
    std::uint32_t seed = 1;  ///< places of the structures
    double edge_grey = 4;    ///< step across a straight edge through the middle; 0: none
    double disc_grey = 5;    ///< brightness of two discs beside the middle; 0: none
    double smooth_px = 3;    ///< standard deviation of the blur of all borders
  };

  explicit PlainCeiling(const Params& params) : params_(params) {
    std::mt19937 random(params.seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    edge_angle_ = std::numbers::pi * unit(random);
    edge_at_ = 40 * unit(random);
    const double first = std::numbers::pi * unit(random);
    for (const double angle : {first, first + 2.2 + 0.5 * unit(random)}) {
      centres_.emplace_back(150 * std::cos(angle), 110 * std::sin(angle));
    }
  }

  /// Unit vector along the edge, on the ceiling.
  [[nodiscard]] Eigen::Vector2d AlongEdge() const {
    return {-std::sin(edge_angle_), std::cos(edge_angle_)};
  }

  /// As SyntheticCeiling::Render.
  [[nodiscard]] cv::Mat Render(cv::Size size,
                               const ImageMotion& motion,
                               double noise_sigma,
                               std::uint32_t noise_seed) const {
    cv::Mat image(size, CV_32FC1);
    cv::RNG random(noise_seed * 2654435761U + 97);
    random.fill(image, cv::RNG::NORMAL, 150, noise_sigma);
    const ImageMotion inverse = motion.Inverse();
    for (int v = 0; v < size.height; ++v) {
      auto* row = image.ptr<float>(v);
      for (int u = 0; u < size.width; ++u) {
        row[u] += static_cast<float>(
            GreyAt(inverse.Apply({u - 0.5 * (size.width - 1), v - 0.5 * (size.height - 1)})));
      }
    }
    cv::Mat grey;
    image.convertTo(grey, CV_8U);
    return grey;
  }

 private:
  [[nodiscard]] double Step(double inside_px) const {
    return 0.5 * std::erfc(-inside_px / (params_.smooth_px * std::numbers::sqrt2));
  }
  [[nodiscard]] double GreyAt(const Eigen::Vector2d& p) const {
    constexpr double kRadius = 45;
    const Eigen::Vector2d across(std::cos(edge_angle_), std::sin(edge_angle_));
    double grey = params_.edge_grey * Step(p.dot(across) - edge_at_);
    for (const Eigen::Vector2d& centre : centres_) {
      grey += params_.disc_grey * Step(kRadius - (p - centre).norm());
    }
    return grey;
  }

  Params params_;
  double edge_angle_ = 0;
  double edge_at_ = 0;
  std::vector<Eigen::Vector2d> centres_;
};

}  // namespace ceilmap::registration::synthetic
