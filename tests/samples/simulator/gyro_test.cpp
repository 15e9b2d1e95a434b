#include "samples/simulator/gyro.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/sensor_truth.hpp"

namespace ceilmap::simulator {
namespace {

/// A metre, a quarter turn to the left on the spot, a metre.
Scene TurningScene() {
  Scene scene;
  scene.path.kind = PathKind::kWaypoints;
  scene.path.waypoints_m = {{2, 2}, {3, 2}, {3, 3}};
  scene.gyro.emplace();
  return scene;
}
// The first metre takes 2 sqrt(1 m / 0.6 m/s^2), the turn 2.5 s with 1.5 s at 45 deg/s.
const double kTurnStart_s = 2 * std::sqrt(1 / 0.6);

std::vector<GyroSample> TurnSamples(const Scene& scene) {
  return MakeGyro(scene, MakePath(scene).back().stamp_s);
}

/// Sum of the samples, radians.
double TurnOf(const std::vector<GyroSample>& samples, double rate_hz) {
  double turn_rad = 0;
  for (const GyroSample& sample : samples) turn_rad += sample.omega_z_rad_s / rate_hz;
  return turn_rad;
}

TEST(Gyro, MeasuresTheTurnRateAtItsStamp) {
  const Scene scene = TurningScene();
  const std::vector<GyroSample> samples = TurnSamples(scene);
  EXPECT_EQ(samples.front().stamp_s, 100);
  EXPECT_NEAR(TurnOf(samples, 100), 90 * kRadPerDeg, 1e-9);
  for (const GyroSample& sample : samples) {
    const double t = sample.stamp_s - 100 - kTurnStart_s;
    const double ramp_deg_s = 90 * std::min(t, 2.5 - t);
    const double rate_deg_s = std::clamp(ramp_deg_s, 0.0, 45.0);
    // At the corners of the ramp the mean over a period of 10 ms differs by up to 0.12 deg/s.
    EXPECT_NEAR(sample.omega_z_rad_s, rate_deg_s * kRadPerDeg, 0.13 * kRadPerDeg) << t;
    if (t > 0.01 && t < 0.49) {
      EXPECT_NEAR(sample.omega_z_rad_s, ramp_deg_s * kRadPerDeg, 1e-9) << t;
    }
  }
}

TEST(Gyro, AFileAtAFewHertzShowsNoSteps) {
  Scene scene = TurningScene();
  scene.path.corner_radius_m = 0.4;
  for (const Frame& frame : MakePath(scene)) {  // 10 Hz
    scene.path.poses.push_back({frame.stamp_s, frame.T_map_base});
  }
  const double smooth_turn = TurnOf(TurnSamples(scene), 100);
  scene.path.kind = PathKind::kTum;
  scene.path.tum_file = "drive.tum";
  const std::vector<GyroSample> samples = TurnSamples(scene);
  EXPECT_NEAR(TurnOf(samples, 100), smooth_turn, 1e-3);
  double largest_step = 0;
  double fastest = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    largest_step =
        std::max(largest_step, std::abs(samples[i].omega_z_rad_s - samples[i - 1].omega_z_rad_s));
    fastest = std::max(fastest, samples[i].omega_z_rad_s);
  }
  EXPECT_GT(fastest, 1.5);
  // Linear interpolation would give steps of half of the rate.
  EXPECT_LT(largest_step, 0.3 * fastest);
}

TEST(Gyro, AroundTheRobotsOwnVertical) {
  Scene scene = TurningScene();
  scene.debris.bumps = {{0.4, 0.4, 10, 0}};  // on the straight
  for (const GyroSample& sample : TurnSamples(scene)) {
    if (sample.stamp_s < 100 + kTurnStart_s - 0.01) {
      EXPECT_NEAR(sample.omega_z_rad_s, 0, 1e-9);
    }
  }
  scene.path.kind = PathKind::kTum;
  scene.path.tum_file = "drive.tum";
  scene.debris.bumps.clear();
  // With its left side raised by 60 degrees it turns about the vertical by 1 rad/s.
  for (int i = 0; i < 20; ++i) {
    PathPose pose{i * 0.1, Eigen::Isometry3d::Identity()};
    pose.T_map_base.translation() = Eigen::Vector3d(4, 4, 0.5);
    pose.T_map_base.rotate(Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitZ()));
    pose.T_map_base.rotate(Eigen::AngleAxisd(60 * kRadPerDeg, Eigen::Vector3d::UnitX()));
    scene.path.poses.push_back(pose);
  }
  for (const GyroSample& sample : TurnSamples(scene)) {
    EXPECT_NEAR(sample.omega_z_rad_s, std::cos(60 * kRadPerDeg), 1e-6);
  }
}

TEST(Gyro, ScaleBiasAndClock) {
  Scene scene = TurningScene();
  scene.gyro->scale_error_ratio = 0.01;
  scene.gyro->bias_deg_s = -0.5;
  scene.gyro->clock_offset_s = 1000;
  const std::vector<GyroSample> samples = TurnSamples(scene);
  EXPECT_EQ(samples.front().stamp_s, 1100);
  const double seconds = static_cast<double>(samples.size()) / 100;
  EXPECT_NEAR(TurnOf(samples, 100), (1.01 * 90 - 0.5 * seconds) * kRadPerDeg, 1e-9);
  EXPECT_THAT(SensorTruthYaml(scene, samples), testing::HasSubstr("  end_bias_deg_s: -0.5\n"));
}

TEST(Gyro, NoiseIsWhiteAndTheBiasWalks) {
  Scene scene;
  scene.path.kind = PathKind::kWaypoints;
  scene.path.waypoints_m = {{2, 2}, {8, 2}};
  scene.gyro.emplace();
  scene.gyro->noise_deg_s = 0.3;
  scene.gyro->bias_walk_deg_s_per_sqrt_s = 0.02;
  constexpr int kSeeds = 200;
  double noise = 0;
  double product = 0;
  double walk = 0;
  double count = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    scene.seed = static_cast<std::uint64_t>(seed);
    const std::vector<GyroSample> samples = MakeGyro(scene, 104);  // 4 s
    double before = 0;
    for (const GyroSample& sample : samples) {
      const double of_sample = sample.omega_z_rad_s - sample.bias_rad_s;
      noise += of_sample * of_sample;
      product += of_sample * before;
      before = of_sample;
      count += 1;
    }
    walk += std::pow(samples.back().bias_rad_s, 2);
  }
  const double variance = std::pow(0.3 * kRadPerDeg, 2);
  EXPECT_NEAR(noise / count, variance, 0.02 * variance);
  EXPECT_NEAR(product / count, 0, 0.02 * variance);
  EXPECT_NEAR(std::sqrt(walk / kSeeds), 0.02 * 2 * kRadPerDeg, 0.2 * 0.04 * kRadPerDeg);
}

TEST(Gyro, IsAbsentUnlessTheSceneHasIt) {
  Scene scene;
  EXPECT_THROW((void)MakeGyro(scene, 110), InputError);
}

}  // namespace
}  // namespace ceilmap::simulator
