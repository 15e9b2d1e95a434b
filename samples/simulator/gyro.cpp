#include "samples/simulator/gyro.hpp"

#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/motion.hpp"
#include "samples/simulator/random.hpp"
#include "samples/simulator/sample_times.hpp"

namespace ceilmap::simulator {
namespace {

/// Turn about base z between two orientations that are close to each other.
double TurnBetween(const Eigen::Matrix3d& R_path_before, const Eigen::Matrix3d& R_path_after) {
  const Eigen::AngleAxisd turn(R_path_before.transpose() * R_path_after);
  return turn.angle() * turn.axis().z();
}

}  // namespace

std::vector<GyroSample> MakeGyro(const Scene& scene, double until_s) {
  if (!scene.gyro) throw InputError("the scene has no gyro; give it the group 'gyro'");
  scene.Validate();
  const Gyro& gyro = *scene.gyro;
  const SampleTimes times = TimesOf(scene, "gyro", gyro.rate_hz, until_s);
  const Motion motion(scene);
  Random random(DriveSeed(scene), Purpose::kGyro);
  double bias_rad_s = gyro.bias_deg_s * kRadPerDeg;
  const double walk_rad_s =
      gyro.bias_walk_deg_s_per_sqrt_s * kRadPerDeg / std::sqrt(gyro.rate_hz);  // of a period
  Eigen::Matrix3d R_before = motion.BaseAt(times.At(-0.5)).linear();
  std::vector<GyroSample> samples;
  samples.reserve(static_cast<std::size_t>(times.count));
  const int parts = times.Parts();
  for (std::int64_t i = 0; i < times.count; ++i) {
    double turn_rad = 0;
    for (int part = 1; part <= parts; ++part) {
      const double end = static_cast<double>(i) - 0.5 + static_cast<double>(part) / parts;
      const Eigen::Matrix3d R_now = motion.BaseAt(times.At(end)).linear();
      turn_rad += TurnBetween(R_before, R_now);
      R_before = R_now;
    }
    const double noise_rad_s = gyro.noise_deg_s * kRadPerDeg * random.Normal();
    const double walked_rad_s = walk_rad_s * random.Normal();
    samples.push_back(
        {StartStamp(scene) + times.At(static_cast<double>(i)) + gyro.clock_offset_s,
         (1 + gyro.scale_error_ratio) * turn_rad * gyro.rate_hz + bias_rad_s + noise_rad_s,
         bias_rad_s});
    bias_rad_s += walked_rad_s;
  }
  return samples;
}

}  // namespace ceilmap::simulator
