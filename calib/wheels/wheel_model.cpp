#include "calib/wheels/wheel_model.hpp"

#include "calib/base/field_check.hpp"

namespace ceilmap::wheels {

double SlipRate::Variance(double travel_m) const {
  const double mean_m = mean_m_per_m * travel_m;
  return mean_m * mean_m + scatter_per_sqrt_m * scatter_per_sqrt_m * travel_m;
}

void WheelModel::Validate() const {
  const FieldCheck require("wheels");
  const auto require_scale = [&](const Uncertain& factor, const char* field) {
    require(factor.value > 0.1 && factor.value < 10, field, factor.value, "in (0.1, 10)");
    require(factor.sigma >= 0 && factor.sigma < 1, field, factor.sigma, "in [0, 1)");
  };
  require_scale(scale, "scale");
  require_scale(turn_scale, "turn_scale");
  require(gyro_bias_rad_s.sigma >= 0, "gyro_bias_rad_s", gyro_bias_rad_s.sigma, ">= 0");
  require(late_s.sigma >= 0, "late_s", late_s.sigma, ">= 0");
  require(gyro_late_s.sigma >= 0, "gyro_late_s", gyro_late_s.sigma, ">= 0");
  require(travel_noise_per_sqrt_m > 0, "travel_noise", travel_noise_per_sqrt_m, "> 0");
  require(yaw_noise_per_sqrt_m > 0, "yaw_noise_per_sqrt_m", yaw_noise_per_sqrt_m, "> 0");
  require(yaw_noise_per_sqrt_rad > 0, "yaw_noise_per_sqrt_rad", yaw_noise_per_sqrt_rad, "> 0");
  require(gyro_noise_per_sqrt_s > 0, "gyro_noise", gyro_noise_per_sqrt_s, "> 0");
  require(slips.mean_m_per_m >= 0, "slips.mean", slips.mean_m_per_m, ">= 0");
  require(slips.scatter_per_sqrt_m >= 0, "slips.scatter", slips.scatter_per_sqrt_m, ">= 0");
}

}  // namespace ceilmap::wheels
