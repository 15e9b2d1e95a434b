#pragma once

#include <numbers>

namespace ceilmap::wheels {

/// A constant of the sensors that is not known exactly.
struct Uncertain {
  double value = 0;
  double sigma = 0;  ///< standard deviation, >= 0
};

/// Slips of the wheels: travel that they report and the robot does not make, or the reverse. They
/// have no usual size; what is known of them is what the ceiling showed.
struct SlipRate {
  double mean_m_per_m = 0;        ///< their sum over a way, >= 0 ...
  double scatter_per_sqrt_m = 0;  ///< ... and its standard deviation after one metre, m, >= 0

  /// Variance of the position in each direction after a way of this length, m2.
  [[nodiscard]] double Variance(double travel_m) const;
};

/// Errors of wheel odometry and of a gyro: those that stay the same, with their standard
/// deviations, and the noise. The defaults suit a differential drive whose constants were measured
/// with a ruler.
struct WheelModel {
  /// True travel / travel reported by the wheels: 1 + error of the wheels' diameter.
  Uncertain scale{1, 0.03};
  /// True turn / turn reported by the wheels: reported / true track width.
  Uncertain turn_scale{1, 0.05};
  /// Reported by a gyro at rest, rad/s, counter-clockwise.
  Uncertain gyro_bias_rad_s{0, 0.01};
  /// How much the stamps of the wheels are later than those of the images, s ...
  Uncertain late_s{0, 0.05};
  Uncertain gyro_late_s{0, 0.05};  ///< ... and those of the gyro

  /// Noise of the travel after one metre, m; it grows with the square root of the travel.
  double travel_noise_per_sqrt_m = 0.01;
  /// The same of the yaw by the wheels, rad, over travel ...
  double yaw_noise_per_sqrt_m = 2 * std::numbers::pi / 180;
  /// ... and over turns.
  double yaw_noise_per_sqrt_rad = 0.02;
  /// Noise of the yaw by a gyro after one second, rad; it grows with the square root of the time.
  double gyro_noise_per_sqrt_s = 0.001;

  SlipRate slips;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

}  // namespace ceilmap::wheels
