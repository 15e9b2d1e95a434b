#include "samples/simulator/wheels.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/sensor_truth.hpp"

namespace ceilmap::simulator {
namespace {

/// A robot with an axle behind the mast that drives around corners, on the spot and on arcs.
Scene WheeledScene(double corner_radius_m = 0) {
  Scene scene;
  scene.axle_behind_mast_m = 0.15;
  scene.path.kind = PathKind::kWaypoints;
  scene.path.waypoints_m = {{2, 2}, {6, 2}, {6, 5}, {3, 6}};
  scene.path.corner_radius_m = corner_radius_m;
  scene.path.frame_rate_hz = 50;
  scene.wheels.emplace();
  scene.wheels->translation_noise_per_sqrt_m = 0;
  return scene;
}

/// Ten metres along x.
Scene StraightWheels() {
  Scene scene = WheeledScene();
  scene.path.waypoints_m = {{1, 2}, {11, 2}};
  return scene;
}

double EndOf(const Scene& scene) {
  return MakePath(scene).back().stamp_s;
}

std::vector<WheelSample> WholeDrive(const Scene& scene) {
  return MakeWheels(scene, EndOf(scene));
}

Pose2 Planar(const Eigen::Isometry3d& T) {
  return {T(0, 3), T(1, 3), std::atan2(T(1, 0), T(0, 0))};
}

/// Largest distance of the odometry from the frames, which have the same times.
double LargestError(const std::vector<WheelSample>& samples, const std::vector<Frame>& frames) {
  EXPECT_EQ(samples.size(), frames.size());
  const Pose2 T_map_odom = Planar(frames.front().T_map_base);
  double largest = 0;
  for (std::size_t i = 0; i < std::min(samples.size(), frames.size()); ++i) {
    EXPECT_NEAR(samples[i].stamp_s, frames[i].stamp_s, 1e-9);
    const Pose2 error =
        Planar(frames[i].T_map_base).Inverse() * (T_map_odom * samples[i].T_odom_base);
    largest = std::max({largest, error.Translation().norm(), std::abs(error.yaw)});
  }
  return largest;
}

TEST(Wheels, ExactOnesFollowThePathOfBase) {
  for (const double radius_m : {0.0, 0.5}) {
    const Scene scene = WheeledScene(radius_m);
    const std::vector<WheelSample> samples = WholeDrive(scene);
    EXPECT_EQ(samples.front().T_odom_base.x, 0);
    EXPECT_EQ(samples.front().T_odom_base.yaw, 0);
    EXPECT_LT(LargestError(samples, MakePath(scene)), 2e-6) << radius_m;
  }
}

TEST(Wheels, ExactSpeedsAddUpToThePathOfTheAxle) {
  const Scene scene = WheeledScene(0.5);
  const double period_s = 1 / scene.wheels->rate_hz;
  const Pose2 T_axle_base{scene.axle_behind_mast_m, 0, 0};
  Pose2 T_odom_axle = T_axle_base.Inverse();
  for (const WheelSample& sample : WholeDrive(scene)) {
    const double turn = sample.omega_rad_s * period_s;
    const double way = sample.v_m_s * period_s;
    T_odom_axle = T_odom_axle * Pose2{way * std::cos(turn / 2), way * std::sin(turn / 2), turn};
    const Pose2 T_odom_base = T_odom_axle * T_axle_base;
    EXPECT_LT((T_odom_base.Translation() - sample.T_odom_base.Translation()).norm(), 3e-4);
    EXPECT_NEAR(WrapAngle(T_odom_base.yaw - sample.T_odom_base.yaw), 0, 1e-9);
  }
}

TEST(Wheels, TurnOnTheSpotHasNoSpeedOfTheAxle) {
  Scene scene = WheeledScene();
  scene.wheels->encoder_step_m = 0;
  double fastest_turn = 0;
  for (const WheelSample& sample : WholeDrive(scene)) {
    if (std::abs(sample.omega_rad_s) < 0.1) continue;
    fastest_turn = std::max(fastest_turn, sample.omega_rad_s);
    // Base moves aside there, the axle does not.
    if (std::abs(sample.omega_rad_s) > 0.7) {
      EXPECT_NEAR(sample.v_m_s, 0, 1e-9);
    }
  }
  EXPECT_NEAR(fastest_turn, 45 * kRadPerDeg, 1e-6);
}

TEST(Wheels, ErrorsOfScaleAndTrackWidthAreThoseOfTravelAndTurn) {
  Scene scene = WheeledScene();
  scene.wheels->scale_error_ratio = 0.02;
  const std::vector<WheelSample> long_way = WholeDrive(scene);
  scene.wheels->scale_error_ratio = 0;
  const std::vector<WheelSample> exact = WholeDrive(scene);
  scene.wheels->track_width_error_ratio = -0.1;
  const std::vector<WheelSample> turns_less = WholeDrive(scene);
  ASSERT_EQ(long_way.size(), exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_NEAR(long_way[i].v_m_s, 1.02 * exact[i].v_m_s, 1e-9);
    EXPECT_NEAR(long_way[i].omega_rad_s, exact[i].omega_rad_s, 1e-9);
    EXPECT_NEAR(turns_less[i].v_m_s, exact[i].v_m_s, 1e-9);
    EXPECT_NEAR(turns_less[i].omega_rad_s, 0.9 * exact[i].omega_rad_s, 1e-9);
  }
}

TEST(Wheels, SlipIsTravelThatTheRobotDoesNotMake) {
  Scene scene = StraightWheels();
  const double end_s = EndOf(scene);
  scene.wheels->slips = {{2.005, 0.5, 0.3}, {6, 1, -0.1}};
  scene.wheels->scale_error_ratio = 0.1;
  const std::vector<WheelSample> slipping = MakeWheels(scene, end_s);
  scene.wheels->slips.clear();
  const std::vector<WheelSample> rolling = MakeWheels(scene, end_s);
  const auto extra_at = [&](double time_s) {
    const auto i = static_cast<std::size_t>(std::lround(time_s * 50));
    return slipping[i].T_odom_base.x - rolling[i].T_odom_base.x;
  };
  EXPECT_NEAR(extra_at(2.0), 0, 1e-12);
  EXPECT_NEAR(extra_at(2.26), 1.1 * 0.3 * 0.51, 1e-9);
  EXPECT_NEAR(extra_at(2.52), 1.1 * 0.3, 1e-9);
  EXPECT_NEAR(extra_at(6.5), 1.1 * (0.3 - 0.05), 1e-9);
  EXPECT_NEAR(extra_at(9), 1.1 * 0.2, 1e-9);
}

TEST(Wheels, EncodersCountStepsOfEachWheel) {
  Scene scene = WheeledScene(0.5);
  scene.wheels->encoder_step_m = 0.01;
  scene.wheels->track_width_m = 0.5;
  double left_m = 0;
  double right_m = 0;
  for (const WheelSample& sample : WholeDrive(scene)) {
    const double way_m = sample.v_m_s / 50;
    const double half_m = sample.omega_rad_s / 50 * 0.25;
    left_m += way_m - half_m;
    right_m += way_m + half_m;
    EXPECT_NEAR(left_m, 0.01 * std::round(left_m / 0.01), 1e-9);
    EXPECT_NEAR(right_m, 0.01 * std::round(right_m / 0.01), 1e-9);
  }
  EXPECT_NEAR((left_m + right_m) / 2, PathLength(scene), 0.01);
  EXPECT_NEAR((right_m - left_m) / 0.5, (90 + 71.565) * kRadPerDeg, 0.02 + 1e-3);
}

TEST(Wheels, GapsHaveNoSamplesAndTheSpeedsAfterThemAreMeansOverThem) {
  Scene scene = StraightWheels();
  scene.wheels->gaps = {{3, 4}};
  scene.wheels->clock_offset_s = -7;
  const std::vector<WheelSample> samples = WholeDrive(scene);
  const auto after = std::find_if(samples.begin(), samples.end(), [](const WheelSample& sample) {
    return sample.stamp_s > 100 - 7 + 2.99;
  });
  EXPECT_NEAR((after - 1)->stamp_s, 95.98, 1e-9);
  EXPECT_NEAR(after->stamp_s, 97.02, 1e-9);
  EXPECT_NEAR(after->v_m_s * 1.04, after->T_odom_base.x - (after - 1)->T_odom_base.x, 1e-9);
}

/// Standard deviation over seeds of the travel and the yaw at the end.
std::pair<double, double> SpreadAtTheEnd(Scene scene) {
  constexpr int kSeeds = 300;
  const double end_s = EndOf(scene);
  const Scene exact = [&] {
    Scene copy = scene;
    copy.wheels = Wheels{};
    copy.wheels->translation_noise_per_sqrt_m = 0;
    return copy;
  }();
  const auto sums_of = [&](const Scene& with) {
    std::pair<double, double> sums;
    for (const WheelSample& sample : MakeWheels(with, end_s)) {
      sums.first += sample.v_m_s / 50;
      sums.second += sample.omega_rad_s / 50;
    }
    return sums;
  };
  const auto truth = sums_of(exact);
  double travel = 0;
  double yaw = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    scene.seed = static_cast<std::uint64_t>(seed);
    const auto sums = sums_of(scene);
    travel += std::pow(sums.first - truth.first, 2);
    yaw += std::pow(sums.second - truth.second, 2);
  }
  return {std::sqrt(travel / kSeeds), std::sqrt(yaw / kSeeds)};
}

TEST(Wheels, NoiseIsThatOfARandomWalk) {
  Scene scene = StraightWheels();
  scene.wheels->translation_noise_per_sqrt_m = 0.01;
  scene.wheels->yaw_noise_deg_per_sqrt_m = 2;
  scene.wheels->yaw_noise_ratio = 0.05;  // without effect: it does not turn
  const auto [travel, yaw] = SpreadAtTheEnd(scene);
  EXPECT_NEAR(travel, 0.01 * std::sqrt(10), 0.15 * 0.01 * std::sqrt(10));
  EXPECT_NEAR(yaw, 2 * kRadPerDeg * std::sqrt(10), 0.15 * 2 * kRadPerDeg * std::sqrt(10));

  Scene turning = WheeledScene();
  turning.wheels->yaw_noise_ratio = 0.05;
  const auto [no_travel, turned] = SpreadAtTheEnd(turning);
  const double expected = 0.05 * std::sqrt((90 + 71.565) * kRadPerDeg);
  EXPECT_NEAR(no_travel, 0, 1e-9);
  EXPECT_NEAR(turned, expected, 0.15 * expected);
}

TEST(Wheels, SamplesDependOnTheSeedAndNotOnTheEnd) {
  Scene scene = WheeledScene();
  scene.wheels->translation_noise_per_sqrt_m = 0.02;
  const std::vector<WheelSample> whole = WholeDrive(scene);
  const std::vector<WheelSample> part = MakeWheels(scene, 104);
  ASSERT_EQ(part.size(), 201U);
  EXPECT_EQ(part.back().T_odom_base.x, whole[200].T_odom_base.x);
  scene.seed = 2;
  EXPECT_NE(part.back().T_odom_base.x, MakeWheels(scene, 104).back().T_odom_base.x);
}

TEST(Wheels, AFilesPosesAreReportedAtTheirTimes) {
  Scene scene = WheeledScene();
  scene.path.frame_rate_hz = 10;
  for (const Frame& frame : MakePath(scene)) {
    scene.path.poses.push_back({frame.stamp_s - 60, frame.T_map_base});
  }
  scene.path.kind = PathKind::kTum;
  scene.path.tum_file = "drive.tum";
  scene.wheels->rate_hz = 10;
  EXPECT_LT(LargestError(WholeDrive(scene), MakePath(scene)), 0.004);
}

TEST(Wheels, AreAbsentUnlessTheSceneHasThem) {
  Scene scene = WheeledScene();
  scene.wheels->rate_hz = 1000;
  EXPECT_THROW((void)MakeWheels(scene, 100 + 2e4), InputError);
  scene.path.kind = PathKind::kTum;
  scene.path.tum_file = "drive.tum";  // without its poses
  EXPECT_THROW((void)MakeWheels(scene, 110), InputError);
  scene.wheels.reset();
  EXPECT_THROW((void)MakeWheels(scene, 110), InputError);
  EXPECT_EQ(SensorTruthYaml(scene, {}), "");
}

TEST(Wheels, TruthStatesTheRatiosAndTheSlips) {
  Scene scene = WheeledScene();
  scene.wheels->scale_error_ratio = 0.02;
  scene.wheels->track_width_error_ratio = -0.03;
  scene.wheels->slips = {{2, 0.5, 0.3}};
  const std::string text = SensorTruthYaml(scene, {});
  EXPECT_THAT(text, testing::HasSubstr("  travel_ratio: 1.02 "));
  EXPECT_THAT(text, testing::HasSubstr("  yaw_ratio: 0.97 "));
  EXPECT_THAT(text, testing::HasSubstr("  axle_x_m: -0.15 "));
  EXPECT_THAT(text,
              testing::HasSubstr(
                  "    - {from_stamp_s: 102.000000, to_stamp_s: 102.500000, extra_m: 0.3}\n"));
}

}  // namespace
}  // namespace ceilmap::simulator
