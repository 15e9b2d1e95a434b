#include "calib/wheels/wheel_calibrator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace ceilmap::wheels {
namespace {

/// A drive whose speed and turn rate change, and what wheels and a gyro report of it.
struct Drive {
  double scale = 1;  // true / reported
  double turn_scale = 1;
  double bias_rad_s = 0;
  double late_s = 0;
  double gyro_late_s = 0;
  double noise = 1;  // of what WheelModel states
  bool gyro = true;
  int seed = 1;
  double slip_every_s = 0;  // 0: never
  double slip_m = 0;        // reported besides the way, within 0.5 s

  static constexpr double kStepS = 0.005;

  static Twist2 Velocity(double stamp_s) {
    return {{0.6 + 0.3 * std::sin(1.1 * stamp_s), 0}, 0.8 * std::sin(0.7 * stamp_s)};
  }

  /// Runs the calibrator over a drive of one minute, seen by images at 20 Hz.
  void Run(WheelCalibrator& calibrator, double from_s = 0, double to_s = 60) const {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const WheelModel model;
    DeadReckoning wheels(calibrator.Model());
    Pose2 truth;
    Pose2 reported;
    double image_s = from_s + 0.1;
    Pose2 at_image;
    for (int i = 0;; ++i) {
      const double stamp_s = from_s + i * kStepS;
      if (stamp_s > to_s) return;
      const Twist2 v = Velocity(stamp_s);
      const Twist2 mean = Velocity(stamp_s + kStepS / 2);  // until the next step
      if (i % 4 == 0) wheels.Add(OdometrySample{stamp_s + late_s, reported});
      if (gyro && i % 2 == 0) {
        const double white =
            noise * model.gyro_noise_per_sqrt_s / std::sqrt(2 * kStepS) * normal(random);
        wheels.Add(GyroSample{stamp_s + gyro_late_s, v.yaw_rad_s + bias_rad_s + white});
      }
      if (stamp_s > image_s + 0.4) {  // images wait until the samples have come
        calibrator.Place(image_s, PoseWithCovariance{at_image}, wheels);
        wheels.SetModel(calibrator.Model());
        image_s += 0.05;
      }
      at_image = PoseAt(image_s, from_s);
      const double length = mean.linear_m_s.x() * kStepS;
      constexpr double kSlipS = 0.5;
      const bool slips =
          slip_every_s > 0 && std::fmod(stamp_s, slip_every_s) > slip_every_s - kSlipS;
      const double travel =
          length + (slips ? slip_m * kStepS / kSlipS : 0) +
          noise * model.travel_noise_per_sqrt_m * std::sqrt(length) * normal(random);
      const double yaw = mean.yaw_rad_s * kStepS +
                         noise * model.yaw_noise_per_sqrt_m * std::sqrt(length) * normal(random);
      reported =
          reported * Twist2{{travel / scale / kStepS, 0}, yaw / turn_scale / kStepS}.Over(kStepS);
    }
  }

  /// The exact pose, integrated finely and kept.
  static Pose2 PoseAt(double stamp_s, double from_s) {
    static std::vector<Pose2> poses{{}};
    constexpr double kFine = 0.0025;
    const auto index = static_cast<std::size_t>((stamp_s - from_s) / kFine + 0.5);
    while (poses.size() <= index) {
      const double middle_s = (static_cast<double>(poses.size()) - 0.5) * kFine;
      poses.push_back(poses.back() * Velocity(middle_s).Over(kFine));
    }
    return poses[index];
  }
};

void ExpectWithin(const Uncertain& estimate, double truth, double tolerance, const char* name) {
  EXPECT_NEAR(estimate.value, truth, tolerance) << name;
  EXPECT_NEAR(estimate.value, truth, 3.5 * estimate.sigma) << name;
}

TEST(WheelCalibrator, FindsAllConstants) {
  for (int seed = 1; seed <= 10; ++seed) {
    Drive drive{1.02, 0.96, 0.006, 0.03, -0.02};
    drive.seed = seed;
    WheelCalibrator calibrator;
    drive.Run(calibrator);
    const WheelModel& model = calibrator.Model();
    ExpectWithin(model.scale, 1.02, 0.006, "scale");
    ExpectWithin(model.gyro_bias_rad_s, 0.006, 0.0006, "bias");
    ExpectWithin(model.late_s, 0.03, 0.012, "late");
    ExpectWithin(model.gyro_late_s, -0.02, 0.003, "gyro late");
    EXPECT_EQ(calibrator.Fault(), WheelFault::kNone);
    ExpectWithin(model.turn_scale, 0.96, 0.02, "turn scale");
    EXPECT_LT(model.turn_scale.sigma, 0.01);
  }
}

TEST(WheelCalibrator, FindsTheTrackWidthWithoutAGyro) {
  for (int seed = 1; seed <= 10; ++seed) {
    Drive drive{0.97, 1.05, 0, 0.02};
    drive.gyro = false;
    drive.seed = seed;
    WheelCalibrator calibrator;
    drive.Run(calibrator);
    ExpectWithin(calibrator.Model().turn_scale, 1.05, 0.02, "turn scale");
    ExpectWithin(calibrator.Model().scale, 0.97, 0.006, "scale");
    EXPECT_LT(calibrator.Model().turn_scale.sigma, 0.01);
  }
}

// Turns that are nothing but noise must not make the scale smaller.
TEST(WheelCalibrator, NoiseDoesNotBiasTheScales) {
  double scale = 0;
  double turn = 0;
  constexpr int kRobots = 10;
  for (int seed = 1; seed <= kRobots; ++seed) {
    Drive drive{0.97, 1.05};
    drive.gyro = false;
    drive.noise = 2.5;
    drive.seed = seed;
    WheelCalibrator calibrator;
    drive.Run(calibrator);
    const WheelModel& model = calibrator.Model();
    scale += (model.scale.value - 0.97) / model.scale.sigma / kRobots;
    turn += (model.turn_scale.value - 1.05) / model.turn_scale.sigma / kRobots;
  }
  EXPECT_NEAR(scale, 0, 1.2);
  EXPECT_NEAR(turn, 0, 1.2);
}

TEST(WheelCalibrator, MeasuresTheSlips) {
  WheelCalibrator good;
  Drive().Run(good);
  EXPECT_EQ(good.Model().slips.Variance(1), 0);
  WheelCalibrator slipping;
  Drive{.slip_every_s = 10, .slip_m = 0.3}.Run(slipping);
  const SlipRate& slips = slipping.Model().slips;
  // Six of them on 36 m, and as if there had been one more.
  EXPECT_NEAR(slips.mean_m_per_m, 7 * 0.3 / 37.8, 0.012);
  EXPECT_NEAR(slips.scatter_per_sqrt_m, 0.3 * std::sqrt(7 / 37.8), 0.03);
  EXPECT_EQ(slipping.Fault(), WheelFault::kNone);
  EXPECT_NEAR(slipping.Model().scale.value, 1, 0.01);
}

TEST(WheelCalibrator, MeasuresTheNoise) {
  for (const double noise : {0.3, 2.5}) {
    Drive drive;
    drive.gyro = false;
    drive.noise = noise;
    WheelCalibrator calibrator;
    drive.Run(calibrator);
    const WheelModel stated;
    EXPECT_NEAR(calibrator.Model().travel_noise_per_sqrt_m / stated.travel_noise_per_sqrt_m,
                noise,
                0.4 * noise);
    EXPECT_NEAR(
        calibrator.Model().yaw_noise_per_sqrt_m / stated.yaw_noise_per_sqrt_m, noise, 0.4 * noise);
  }
}

TEST(WheelCalibrator, NamesWhatCannotBe) {
  const auto fault_of = [](const Drive& drive) {
    WheelCalibrator calibrator;
    drive.Run(calibrator, 0, 30);
    return calibrator.Fault();
  };
  Drive sound;
  sound.gyro = false;
  EXPECT_EQ(fault_of(sound), WheelFault::kNone);
  Drive mirrored = sound;
  mirrored.turn_scale = -1;
  EXPECT_EQ(fault_of(mirrored), WheelFault::kOppositeYaw);
  Drive millimetres = sound;
  millimetres.scale = 0.001;
  EXPECT_EQ(fault_of(millimetres), WheelFault::kUnits);
  Drive backwards = sound;
  backwards.scale = -1;
  EXPECT_EQ(fault_of(backwards), WheelFault::kOppositeTravel);
  Drive other_clock = sound;
  other_clock.late_s = 2.2;
  EXPECT_EQ(fault_of(other_clock), WheelFault::kUnrelated);
}

TEST(WheelCalibrator, ALossEndsAPiece) {
  WheelCalibrator calibrator;
  DeadReckoning wheels;
  for (int i = 0; i <= 100; ++i) wheels.Add(OdometrySample{0.02 * i, {0.02 * i, 0, 0}});
  EXPECT_FALSE(calibrator.Place(0.1, PoseWithCovariance{{0.1, 0, 0}}, wheels));
  EXPECT_FALSE(calibrator.Place(0.2, std::nullopt, wheels));
  // Poses after it may be in another place: nothing is compared across the loss.
  EXPECT_FALSE(calibrator.Place(0.9, PoseWithCovariance{{7, 0, 0}}, wheels));
  EXPECT_TRUE(calibrator.Place(1.4, PoseWithCovariance{{7.5, 0, 0}}, wheels));
  EXPECT_EQ(calibrator.Pieces(), 1);
  EXPECT_EQ(calibrator.Slips(), 0);
}

}  // namespace
}  // namespace ceilmap::wheels
