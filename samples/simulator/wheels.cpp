#include "samples/simulator/wheels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/motion.hpp"
#include "samples/simulator/random.hpp"
#include "samples/simulator/sample_times.hpp"

namespace ceilmap::simulator {
namespace {

/// Motion of the middle of the axle in a short time.
struct Travel {
  double ds_m = 0;  ///< along the arc, negative backwards
  double dyaw_rad = 0;
};

/// Length of an arc relative to its chord.
double ArcPerChord(double dyaw_rad) {
  const double half = dyaw_rad / 2;
  return std::abs(half) < 1e-9 ? 1 : half / std::sin(half);
}

/// The true travel. A sideways motion, which wheels do not see, is left out.
Travel TravelBetween(const Pose2& T_path_before, const Pose2& T_path_after) {
  const Pose2 moved = T_path_before.Inverse() * T_path_after;
  const double half = moved.yaw / 2;
  const double chord = moved.x * std::cos(half) + moved.y * std::sin(half);
  return {chord * ArcPerChord(moved.yaw), moved.yaw};
}

/// The pose after a travel, relative to the one before.
Pose2 ArcOf(const Travel& travel) {
  const double chord = travel.ds_m / ArcPerChord(travel.dyaw_rad);
  const double half = travel.dyaw_rad / 2;
  return {chord * std::cos(half), chord * std::sin(half), WrapAngle(travel.dyaw_rad)};
}

double SlipBetween(const std::vector<Slip>& slips, double from_s, double to_s) {
  double extra_m = 0;
  for (const Slip& slip : slips) {
    const double shared_s =
        std::min(to_s, slip.at_s + slip.duration_s) - std::max(from_s, slip.at_s);
    extra_m += slip.extra_m * std::max(0.0, shared_s) / slip.duration_s;
  }
  return extra_m;
}

/// The two encoders.
class Encoders {
 public:
  Encoders(const Wheels& wheels, std::uint64_t seed)
      : wheels_(wheels), random_(seed, Purpose::kWheels) {}

  /// What they count of a travel.
  Travel Count(const Travel& travel, double slip_m) {
    const double root_m = std::sqrt(std::abs(travel.ds_m));
    const double root_rad = std::sqrt(std::abs(travel.dyaw_rad));
    const double ds_m = (1 + wheels_.scale_error_ratio) * (travel.ds_m + slip_m) +
                        wheels_.translation_noise_per_sqrt_m * root_m * random_.Normal();
    const double yaw_noise_rad =
        wheels_.yaw_noise_deg_per_sqrt_m * kRadPerDeg * root_m * random_.Normal();
    const double dyaw_rad = (1 + wheels_.track_width_error_ratio) * travel.dyaw_rad +
                            yaw_noise_rad + wheels_.yaw_noise_ratio * root_rad * random_.Normal();
    const double half_m = wheels_.track_width_m / 2 * dyaw_rad;
    const double left_m = left_.Advance(ds_m - half_m, wheels_.encoder_step_m);
    const double right_m = right_.Advance(ds_m + half_m, wheels_.encoder_step_m);
    return {(left_m + right_m) / 2, (right_m - left_m) / wheels_.track_width_m};
  }

 private:
  struct Wheel {
    double turned_m = 0;
    double counted_m = 0;

    /// @return the change of the count.
    double Advance(double travel_m, double step_m) {
      turned_m += travel_m;
      const double before_m = counted_m;
      counted_m = step_m > 0 ? std::round(turned_m / step_m) * step_m : turned_m;
      return counted_m - before_m;
    }
  };

  const Wheels& wheels_;
  Random random_;
  Wheel left_;
  Wheel right_;
};

/// Odometry by the encoders.
class Odometer {
 public:
  Odometer(const Scene& scene, double start_s)
      : wheels_(*scene.wheels),
        motion_(scene),
        encoders_(wheels_, DriveSeed(scene)),
        T_axle_base_{scene.axle_behind_mast_m, 0, 0},
        time_s_(start_s),
        T_path_axle_(motion_.AxleAt(start_s)),
        T_odom_axle_(T_axle_base_.Inverse()) {}

  void Drive(double to_s) {
    const Pose2 T_path_axle = motion_.AxleAt(to_s);
    const Travel counted = encoders_.Count(TravelBetween(T_path_axle_, T_path_axle),
                                           SlipBetween(wheels_.slips, time_s_, to_s));
    T_odom_axle_ = T_odom_axle_ * ArcOf(counted);
    since_sample_.ds_m += counted.ds_m;
    since_sample_.dyaw_rad += counted.dyaw_rad;
    T_path_axle_ = T_path_axle;
    time_s_ = to_s;
  }

  [[nodiscard]] Pose2 Pose() const { return T_odom_axle_ * T_axle_base_; }
  /// The travel since the call before.
  Travel TakeTravel() { return std::exchange(since_sample_, {}); }

 private:
  const Wheels& wheels_;
  Motion motion_;
  Encoders encoders_;
  Pose2 T_axle_base_;
  double time_s_;
  Pose2 T_path_axle_;
  Pose2 T_odom_axle_;
  Travel since_sample_;
};

bool InGap(const Wheels& wheels, double time_s) {
  return std::any_of(wheels.gaps.begin(), wheels.gaps.end(), [time_s](const TimeSpan& gap) {
    return gap.Contains(time_s);
  });
}

}  // namespace

std::vector<WheelSample> MakeWheels(const Scene& scene, double until_s) {
  if (!scene.wheels) throw InputError("the scene has no wheels; give it the group 'wheels'");
  scene.Validate();
  const Wheels& wheels = *scene.wheels;
  const SampleTimes times = TimesOf(scene, "wheels", wheels.rate_hz, until_s);
  const double clock_s = StartStamp(scene) + wheels.clock_offset_s;
  Odometer odometer(scene, times.first_s);
  std::int64_t last = -1;  // index of the last sample
  std::vector<WheelSample> samples;
  samples.reserve(static_cast<std::size_t>(times.count));
  const int parts = times.Parts();
  for (std::int64_t i = 0; i < times.count; ++i) {
    const auto index = static_cast<double>(i);
    for (int part = 1; part <= parts && i > 0; ++part) {
      odometer.Drive(times.At(index - 1 + static_cast<double>(part) / parts));
    }
    if (InGap(wheels, times.At(index))) continue;
    const Travel travel = odometer.TakeTravel();
    const double per_s = last < 0 ? 0 : wheels.rate_hz / static_cast<double>(i - last);
    samples.push_back(
        {clock_s + times.At(index), odometer.Pose(), travel.ds_m * per_s, travel.dyaw_rad * per_s});
    last = i;
  }
  return samples;
}

}  // namespace ceilmap::simulator
