#pragma once

#include <vector>

namespace ceilmap::simulator {

/// From..to in the scene's time (StartStamp), both included.
struct TimeSpan {
  double from_s = 0;
  double to_s = 0;

  [[nodiscard]] bool Contains(double time_s) const {
    constexpr double kRounding = 1e-9;  // of stamps
    return time_s > from_s - kRounding && time_s < to_s + kRounding;
  }
};

/// Content of the rows of a recording of wheels.
enum class WheelsKind {
  kPose,   ///< pose of base in the odometry frame, which is base of the first sample
  kSpeeds  ///< forward speed of the axle's middle and turn rate, means since the sample before
};

/// Both wheels turn further than the robot drives, evenly during a time.
struct Slip {
  double at_s = 0;  ///< beginning
  double duration_s = 0.5;
  double extra_m = 0.4;  ///< of travel that the wheels show and the robot does not make
};

/// Wheel encoders of a differential drive: two wheels on the axle, at +-track_width_m / 2 of its
/// middle, do not move sideways. What they report of the true travel ds and turn dyaw of a short
/// time is
///
///   (1 + scale_error_ratio) (ds + slip) + translation_noise_per_sqrt_m sqrt|ds| n1
///   (1 + track_width_error_ratio) dyaw + yaw_noise_deg_per_sqrt_m sqrt|ds| n2
///                                      + yaw_noise_ratio sqrt|dyaw| n3
///
/// with independent normal numbers n1, n2, n3: random walks with the stated standard deviation
/// after one metre, or one radian. It is then divided into the travel of the two wheels, which the
/// encoders count in steps.
struct Wheels {
  double rate_hz = 50;
  WheelsKind kind = WheelsKind::kPose;
  double track_width_m = 0.4;
  double scale_error_ratio = 0;
  /// Of the yaw rate only. A robot with both wheels larger than stated has this error too.
  double track_width_error_ratio = 0;
  double translation_noise_per_sqrt_m = 0.01;  ///< m / sqrt(m)
  double yaw_noise_deg_per_sqrt_m = 0;
  double yaw_noise_ratio = 0;  ///< rad / sqrt(rad)
  double encoder_step_m = 0;   ///< of each wheel's travel; 0: not quantised
  double clock_offset_s = 0;   ///< added to the true time of a sample
  std::vector<Slip> slips;
  std::vector<TimeSpan> gaps;  ///< without samples
};

/// A gyro about base z. A sample is (1 + scale_error_ratio) times the true rate, plus a bias that
/// is a random walk, plus white noise.
struct Gyro {
  double rate_hz = 100;
  double noise_deg_s = 0;  ///< standard deviation of a sample
  double bias_deg_s = 0;   ///< at the start
  double bias_walk_deg_s_per_sqrt_s = 0;
  double scale_error_ratio = 0;
  double clock_offset_s = 0;  ///< added to the true time of a sample
};

}  // namespace ceilmap::simulator
