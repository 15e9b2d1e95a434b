#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/base/tilt.hpp"

namespace ceilmap::compensation {

struct TiltFilterParams {
  /// Standard deviation of the angular acceleration, rad/s^2, > 0. A wheel climbs a cable in a
  /// tenth of a second, so measurements outweigh the prediction; it bridges single frames and tells
  /// outliers.
  double acceleration = 3;
  /// Of the first angles, rad, and rates, rad/s.
  double first_sigma_rad = 0.1;
  double first_rate_sigma = 0.5;
  /// A measurement farther from what was expected, in standard deviations, is not taken over.
  double max_sigmas = 5;
  /// Longer without frames, s: rates are forgotten.
  double forget_s = 0.5;
};

/// Kalman filter of pitch and roll, their rates moved by white acceleration.
class TiltFilter {
 public:
  explicit TiltFilter(const TiltFilterParams& params = {}) : params_(params) {}

  /// Forward to this time, which must not go back; starts level and unsure.
  void Predict(double stamp_s);
  /// @return false when the angles were too far off, and not used.
  bool Update(const TiltAngles& measured);
  /// Takes the angles as they are; rates start anew. For what is sure after `Update` refused it.
  void Restart(const TiltAngles& measured);

  [[nodiscard]] TiltAngles Now() const {
    return {state_.head<2>(), covariance_.topLeftCorner<2, 2>()};
  }

 private:
  void ForgetRates();

  TiltFilterParams params_;
  std::optional<double> stamp_s_;
  Eigen::Vector4d state_ = Eigen::Vector4d::Zero();  // pitch, roll, their rates
  Eigen::Matrix4d covariance_ = Eigen::Matrix4d::Zero();
};

}  // namespace ceilmap::compensation
