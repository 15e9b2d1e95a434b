#include "calib/wheels/dead_reckoning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"

namespace ceilmap::wheels {
namespace {

constexpr double kMaxGapS = 0.5;    // between samples
constexpr double kMaxHoldS = 0.15;  // after the last sample
constexpr double kKeptS = 120;
// No robot is faster, and no pose further away. A recording in other units may be.
constexpr double kMaxM = 1e9;
constexpr double kMaxMS = 1e6;
constexpr double kMaxRadS = 1e6;
// Noise across the direction of travel, as a part of that along it: wheels slip little sideways.
constexpr double kAcrossRatio = 0.5;

void CheckStamp(const char* sensor, double stamp_s, std::optional<double> before_s) {
  if (!std::isfinite(stamp_s)) {
    throw InputError(fmt::format("{}: a time is not finite", sensor));
  }
  if (before_s && !(stamp_s > *before_s)) {
    throw InputError(fmt::format("{}: time {} s is not later than that of the sample before, {} s",
                                 sensor,
                                 stamp_s,
                                 *before_s));
  }
}

template <typename Sample>
std::optional<double> LastStamp(const std::deque<Sample>& samples) {
  if (samples.empty()) return std::nullopt;
  return samples.back().stamp_s;
}

template <typename Sample>
void DropOld(std::deque<Sample>& samples) {
  while (samples.back().stamp_s - samples.front().stamp_s > kKeptS) samples.pop_front();
}

/// The first sample that is later than a time.
template <typename Sample>
auto FirstAfter(const std::deque<Sample>& samples, double stamp_s) {
  return std::upper_bound(
      samples.begin(), samples.end(), stamp_s, [](double stamp, const Sample& sample) {
        return stamp < sample.stamp_s;
      });
}

}  // namespace

DeadReckoning::DeadReckoning(const WheelModel& model, double axle_behind_m)
    : T_base_axle_{-axle_behind_m, 0, 0} {
  SetModel(model);
}

void DeadReckoning::SetModel(const WheelModel& model) {
  model.Validate();
  model_ = model;
}

void DeadReckoning::Add(const OdometrySample& sample) {
  if (speeds_.value_or(false)) throw InputError("odometry: poses and speeds cannot be mixed");
  const Pose2& T = sample.T_odom_base;
  if (!std::isfinite(T.x + T.y + T.yaw)) {
    throw InputError(fmt::format("odometry: the pose at {} s is not finite", sample.stamp_s));
  }
  if (T.Translation().cwiseAbs().maxCoeff() > kMaxM) {
    throw InputError(
        fmt::format("odometry: the pose at {} s is more than {} m away, must be in metres",
                    sample.stamp_s,
                    kMaxM));
  }
  CheckStamp("odometry", sample.stamp_s, LastStamp(wheels_));
  speeds_ = false;
  AxlePose pose{sample.stamp_s, T * T_base_axle_};
  pose.jumped = Jumps(pose);
  wheels_.push_back(pose);
  ++samples_;
  DropOld(wheels_);
}

void DeadReckoning::Add(const WheelSpeedSample& sample) {
  if (!speeds_.value_or(true)) throw InputError("odometry: poses and speeds cannot be mixed");
  const Twist2& v = sample.velocity;
  if (!v.linear_m_s.allFinite() || !std::isfinite(v.yaw_rad_s)) {
    throw InputError(fmt::format("odometry: the speed at {} s is not finite", sample.stamp_s));
  }
  if (v.linear_m_s.norm() > kMaxMS || std::abs(v.yaw_rad_s) > kMaxRadS) {
    throw InputError(fmt::format(
        "odometry: the speed at {} s is more than {} m/s or rad/s", sample.stamp_s, kMaxMS));
  }
  CheckStamp("odometry", sample.stamp_s, LastStamp(wheels_));
  speeds_ = true;
  AxlePose pose{sample.stamp_s, {}};
  if (!wheels_.empty()) {
    const AxlePose& before = wheels_.back();
    // Nothing is asked about a gap.
    const double elapsed_s = std::min(sample.stamp_s - before.stamp_s, kMaxGapS);
    pose.T_odom_axle = before.T_odom_axle * v.Over(elapsed_s);
  }
  wheels_.push_back(pose);
  ++samples_;
  DropOld(wheels_);
}

void DeadReckoning::Add(const GyroSample& sample) {
  if (!std::isfinite(sample.yaw_rate_rad_s)) {
    throw InputError(fmt::format("gyro: the turn rate at {} s is not finite", sample.stamp_s));
  }
  if (std::abs(sample.yaw_rate_rad_s) > kMaxRadS) {
    throw InputError(
        fmt::format("gyro: the turn rate at {} s is more than {} rad/s", sample.stamp_s, kMaxRadS));
  }
  CheckStamp("gyro", sample.stamp_s, LastStamp(gyro_));
  Turned turned{sample.stamp_s, sample.yaw_rate_rad_s, 0};
  if (!gyro_.empty()) {
    const Turned& before = gyro_.back();
    turned.yaw_rad = before.yaw_rad + 0.5 * (before.rate_rad_s + turned.rate_rad_s) *
                                          std::min(turned.stamp_s - before.stamp_s, kMaxGapS);
  }
  NoteStuck(sample);
  gyro_.push_back(turned);
  DropOld(gyro_);
}

bool DeadReckoning::Stuck::IsSure() const {
  constexpr double kMinS = 0.1;
  constexpr int kMinSamples = 3;
  return samples >= kMinSamples && to_s - from_s >= kMinS;
}

/// Before the sample is kept.
void DeadReckoning::NoteStuck(const GyroSample& sample) {
  const bool same = !gyro_.empty() && gyro_.back().rate_rad_s == sample.yaw_rate_rad_s &&
                    sample.stamp_s - gyro_.back().stamp_s <= kMaxGapS;
  if (same && !stuck_.empty()) {
    stuck_.back().to_s = sample.stamp_s;
    ++stuck_.back().samples;
    return;
  }
  if (!stuck_.empty() && !stuck_.back().IsSure()) {
    stuck_.pop_back();
  } else if (!stuck_.empty()) {
    stuck_seconds_ += stuck_.back().to_s - stuck_.back().from_s;
  }
  stuck_.push_back({sample.stamp_s, sample.stamp_s, 1});
  while (sample.stamp_s - stuck_.front().to_s > kKeptS) stuck_.pop_front();
}

double DeadReckoning::StuckSeconds() const {
  const bool now = !stuck_.empty() && stuck_.back().IsSure();
  return stuck_seconds_ + (now ? stuck_.back().to_s - stuck_.back().from_s : 0);
}

/// Whether the gyro was stuck at any time between two times of its clock. Held after the last
/// sample, it is what it was there.
bool DeadReckoning::IsStuck(double from_s, double to_s) const {
  for (auto stuck = stuck_.rbegin(); stuck != stuck_.rend(); ++stuck) {
    if (stuck->to_s < from_s && stuck != stuck_.rbegin()) return false;
    const bool until_now = stuck == stuck_.rbegin();
    if (stuck->IsSure() && stuck->from_s < to_s && (until_now || stuck->to_s > from_s)) return true;
  }
  return false;
}

/// Whether the pose is where no robot gets from the last one, which moved as robots do: it was set
/// by something else, a correction or a new beginning.
bool DeadReckoning::Jumps(const AxlePose& now) const {
  constexpr double kMinM = 0.25;
  constexpr double kMinRad = 0.5;
  constexpr double kSpeedMS = 10;
  constexpr double kRateRadS = 20;
  constexpr double kSudden = 10;  // times the step before: other units are no jump
  if (wheels_.size() < 2) return false;
  const AxlePose& last = wheels_.back();
  const AxlePose& before = *std::prev(wheels_.end(), 2);
  const double elapsed_s = now.stamp_s - last.stamp_s;
  const Pose2 step = last.T_odom_axle.Inverse() * now.T_odom_axle;
  const Pose2 step_before = before.T_odom_axle.Inverse() * last.T_odom_axle;
  const double usual = kSudden * elapsed_s / (last.stamp_s - before.stamp_s);
  const double length = step.Translation().norm();
  const double turn = std::abs(step.yaw);
  return (length > kMinM + kSpeedMS * elapsed_s &&
          length > usual * step_before.Translation().norm()) ||
         (turn > kMinRad + kRateRadS * elapsed_s && turn > usual * std::abs(step_before.yaw));
}

/// Integral of the rate up to a time, linear between the samples.
std::optional<double> DeadReckoning::GyroYaw(double stamp_s) const {
  const auto after = FirstAfter(gyro_, stamp_s);
  if (after == gyro_.begin()) return std::nullopt;
  const Turned& before = *std::prev(after);
  const double elapsed_s = stamp_s - before.stamp_s;
  double rate_rad_s = before.rate_rad_s;  // in the middle of the time since `before`
  if (after == gyro_.end()) {
    if (elapsed_s > kMaxHoldS) return std::nullopt;
  } else {
    const double gap_s = after->stamp_s - before.stamp_s;
    if (gap_s > kMaxGapS) return std::nullopt;
    rate_rad_s += 0.5 * (after->rate_rad_s - before.rate_rad_s) * elapsed_s / gap_s;
  }
  return before.yaw_rad + rate_rad_s * elapsed_s;
}

/// The turn between two times of the gyro's clock.
std::optional<RelativeTurn> DeadReckoning::GyroTurn(double from_s,
                                                    double to_s,
                                                    const WheelModel& model) const {
  if (gyro_.empty()) return std::nullopt;
  // Without wheels nothing else measures the turn, and a gyro may report rest by an exact zero.
  if (!wheels_.empty() && IsStuck(from_s, to_s)) return std::nullopt;
  const std::optional<double> from = GyroYaw(from_s);
  const std::optional<double> to = GyroYaw(to_s);
  if (!from || !to) return std::nullopt;
  const double elapsed_s = to_s - from_s;
  return RelativeTurn{*to - *from - model.gyro_bias_rad_s.value * elapsed_s,
                      model.gyro_noise_per_sqrt_s * model.gyro_noise_per_sqrt_s * elapsed_s,
                      model.gyro_bias_rad_s.sigma * elapsed_s,
                      false};
}

/// A step of constant velocity with its errors, at times of the wheels' clock. The true step lies
/// along the chord that is turned by half the turn.
RelativeMotion DeadReckoning::Step(const Pose2& reported,
                                   double from_s,
                                   double to_s,
                                   const WheelModel& model,
                                   TurnBy turn_by) const {
  const Eigen::Vector2d ahead =
      model.scale.value * (Pose2{0, 0, -reported.yaw / 2}.Rotation() *
                           reported.Translation());  // in the axes at the step's middle
  const double gyro_s = model.gyro_late_s.value - model.late_s.value;
  std::optional<RelativeTurn> by_gyro;
  if (turn_by != TurnBy::kWheels) by_gyro = GyroTurn(from_s + gyro_s, to_s + gyro_s, model);
  const double turn = by_gyro ? by_gyro->turn_rad : model.turn_scale.value * reported.yaw;
  const Eigen::Matrix2d R = Pose2{0, 0, turn / 2}.Rotation();
  const Eigen::Vector2d step = R * ahead;
  RelativeMotion motion;
  motion.T_before_now = {step.x(), step.y(), WrapAngle(turn)};
  const double length = ahead.norm();
  const double along2 = model.travel_noise_per_sqrt_m * model.travel_noise_per_sqrt_m * length;
  if (length > 0) {
    const Eigen::Vector2d direction = step / length;
    const double across2 = kAcrossRatio * kAcrossRatio * along2;
    motion.noise.topLeftCorner<2, 2>() = across2 * Eigen::Matrix2d::Identity() +
                                         (along2 - across2) * direction * direction.transpose();
  }
  const auto squared = [](double noise, double amount) { return noise * noise * amount; };
  motion.noise(2, 2) = by_gyro ? by_gyro->noise_rad2
                               : squared(model.yaw_noise_per_sqrt_m, length) +
                                     squared(model.yaw_noise_per_sqrt_rad, std::abs(turn));
  motion.common.col(0) << step / model.scale.value * model.scale.sigma, 0;
  motion.travel_m = length;
  motion.slips = model.slips;
  const double turn_error = by_gyro ? by_gyro->common_rad : model.turn_scale.sigma * reported.yaw;
  motion.common.col(1) << 0.5 * turn_error * Eigen::Vector2d(-step.y(), step.x()), turn_error;
  return motion;
}

std::optional<RelativeMotion> DeadReckoning::Between(double from_s, double to_s) const {
  std::optional<RelativeMotion> motion = AxleBetween(from_s, to_s, model_);
  if (!motion) return std::nullopt;
  const Pose2 T_axle_base = T_base_axle_.Inverse();
  const Pose2 T_before_now = motion->T_before_now;
  // The turn moves base around the axle.
  const Eigen::Vector2d lever = T_before_now.Rotation() * T_axle_base.Translation();
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J.topRightCorner<2, 1>() << -lever.y(), lever.x();
  motion->T_before_now = T_base_axle_ * T_before_now * T_axle_base;
  motion->noise = J * motion->noise * J.transpose();
  motion->common = J * motion->common;
  return motion;
}

std::optional<RelativeMotion> DeadReckoning::AxleBetween(double from_s,
                                                         double to_s,
                                                         const WheelModel& model) const {
  return AxleMotion(from_s, to_s, model, TurnBy::kGyroOrWheels);
}

std::optional<RelativeMotion> DeadReckoning::AxleMotion(double from_s,
                                                        double to_s,
                                                        const WheelModel& model,
                                                        TurnBy turn_by) const {
  const double end_s = to_s + model.late_s.value;
  double at_s = from_s + model.late_s.value;
  auto next = FirstAfter(wheels_, at_s);
  if (next == wheels_.begin() || wheels_.size() < 2) return std::nullopt;
  RelativeMotion motion;
  while (at_s < end_s) {
    // The step that contains `at_s`; after the last sample the last step goes on.
    const bool held = next == wheels_.end();
    const AxlePose& after = held ? wheels_.back() : *next;
    const AxlePose& before = held ? *std::prev(next, 2) : *std::prev(next);
    const double gap_s = after.stamp_s - before.stamp_s;
    if (gap_s > kMaxGapS || after.jumped || (held && end_s - after.stamp_s > kMaxHoldS))
      return std::nullopt;
    const double until_s = held ? end_s : std::min(end_s, after.stamp_s);
    const Pose2 whole = before.T_odom_axle.Inverse() * after.T_odom_axle;
    motion =
        motion * Step(Interpolate(whole, (until_s - at_s) / gap_s), at_s, until_s, model, turn_by);
    at_s = until_s;
    if (!held) ++next;
  }
  return motion;
}

std::optional<RelativeTurn> DeadReckoning::TurnBetween(double from_s, double to_s) const {
  return TurnBetween(from_s, to_s, model_);
}

std::optional<RelativeTurn> DeadReckoning::TurnBetween(double from_s,
                                                       double to_s,
                                                       const WheelModel& model) const {
  const double late_s = model.gyro_late_s.value;
  if (const auto by_gyro = GyroTurn(from_s + late_s, to_s + late_s, model)) return by_gyro;
  return WheelTurnBetween(from_s, to_s, model);
}

std::optional<RelativeTurn> DeadReckoning::WheelTurnBetween(double from_s,
                                                            double to_s,
                                                            const WheelModel& model) const {
  const std::optional<RelativeMotion> motion = AxleMotion(from_s, to_s, model, TurnBy::kWheels);
  if (!motion) return std::nullopt;
  return RelativeTurn{motion->T_before_now.yaw, motion->noise(2, 2), motion->common(2, 1), true};
}

}  // namespace ceilmap::wheels
