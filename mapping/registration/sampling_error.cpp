#include "mapping/registration/sampling_error.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace ceilmap::registration {

SamplingError::SamplingError(const std::vector<float>& window)
    : middle_(std::floor(0.5 * static_cast<double>(window.size()))) {
  const double centre = 0.5 * (static_cast<double>(window.size()) - 1);
  double all = 0;
  double moment = 0;
  for (std::size_t i = 0; i < window.size(); ++i) {
    const double weight = static_cast<double>(window[i]) * window[i];
    all += weight;
    moment += weight * std::pow(static_cast<double>(i) - centre, 2);
  }
  sigma_px_ = std::sqrt(moment / all);
}

Eigen::Vector2d SamplingError::Expected(const kernels::Affine& map,
                                        const Eigen::Matrix2d& sharpness) const {
  // Pixels, of content that fills PocParams::band_sigma: the peak of a block of white content that
  // Catmull-Rom's interpolation has sampled a quarter of a pixel beside its pixels.
  constexpr double kShift = 0.025;
  constexpr double kTurn = 2 * std::numbers::pi;
  const Eigen::Vector2d at(map.x0 + (map.xx + map.xy) * middle_,
                           map.y0 + (map.yx + map.yy) * middle_);
  Eigen::Matrix2d linear;
  linear << map.xx, map.xy, map.yx, map.yy;
  const Eigen::Matrix2d back = linear.inverse();
  const Eigen::Matrix2d seen = back.transpose() * sharpness * back;
  Eigen::Vector2d error;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = linear.row(axis).transpose();  // from one sample to the next
    const Eigen::Vector2d drift = step - Eigen::Vector2d(step.array().round());
    const double alike = std::exp(-0.5 * std::pow(kTurn * sigma_px_, 2) * drift.squaredNorm());
    error[axis] = -kShift * seen(axis, axis) * alike * std::sin(kTurn * at[axis]);
  }
  return back * error;
}

}  // namespace ceilmap::registration
