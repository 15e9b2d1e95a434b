#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/base/tilt.hpp"

namespace ceilmap::compensation {

struct TiltFilterParams {
  /// Standard deviation of the angular acceleration, rad/s^2, > 0. A wheel climbs a cable within
  /// 0.1 s, so measurements outweigh the prediction. The prediction bridges single frames and
  /// detects outliers.
  double acceleration = 3;
};

/// Kalman filter of pitch and roll. White angular acceleration drives their rates.
class TiltFilter {
 public:
  explicit TiltFilter(const TiltFilterParams& params = {}) : params_(params) {}

  /// Predicts to this time, which must not go back. The initial state is level with a large
  /// covariance. The rates continue over single frames without a measurement only.
  void Predict(double stamp_s);
  /// @return false when the angles were rejected as an outlier and not used.
  bool Update(const TiltAngles& measured);
  /// Sets the angles to a measurement; the rates are reset. For a reliable measurement that
  /// `Update` rejected.
  void Restart(const TiltAngles& measured);

  [[nodiscard]] TiltAngles Now() const {
    return {state_.head<2>(), covariance_.topLeftCorner<2, 2>()};
  }

 private:
  void ForgetRates();

  TiltFilterParams params_;
  std::optional<double> stamp_s_;
  double measured_s_ = 0;                            // time of the last measurement that was used
  Eigen::Vector4d state_ = Eigen::Vector4d::Zero();  // pitch, roll, their rates
  Eigen::Matrix4d covariance_ = Eigen::Matrix4d::Zero();
};

}  // namespace ceilmap::compensation
