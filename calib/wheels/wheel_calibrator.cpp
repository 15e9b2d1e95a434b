#include "calib/wheels/wheel_calibrator.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace ceilmap::wheels {
namespace {

// A piece ends after this travel, turn or time. Shorter pieces show changes of speed, on which the
// delays are seen; longer ones lie above the errors of single images.
constexpr double kPieceM = 0.25;
constexpr double kPieceRad = 0.3;
constexpr double kPieceS = 0.5;
// Standard deviations of a motion that the ceiling shows, at least.
constexpr double kSeenSigmaM = 5e-4;
constexpr double kSeenSigmaRad = 5e-4;
constexpr double kMaxSigmas = 4;  // a piece that differs more is a slip
// Random walk of the gyro's bias, rad/s after one second.
constexpr double kBiasWalk = 1e-4;

constexpr std::size_t kNoisePieces = 150;  // of which the noise is estimated
constexpr std::size_t kFewestPieces = 20;  // before that the noise stays as it is stated
constexpr double kMinNoiseFactor = 0.2;
constexpr double kMaxNoiseFactor = 5;

/// Standard deviation of values whose few largest are disturbed.
double RobustSigma(const std::deque<double>& values) {
  std::vector<double> sizes;
  sizes.reserve(values.size());
  for (const double value : values) sizes.push_back(std::abs(value));
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  constexpr double kMedianOfNormal = 0.6745;
  constexpr double kDisturbed = 3.5;
  const double limit = kDisturbed * *middle / kMedianOfNormal;
  double squares = 0;
  int count = 0;
  for (const double size : sizes) {
    if (size > limit) continue;
    squares += size * size;
    ++count;
  }
  return std::sqrt(squares / count);
}

void Keep(double value, std::deque<double>& values) {
  values.push_back(value);
  if (values.size() > kNoisePieces) values.pop_front();
}

/// The noise of the latest pieces, as a multiple of what was stated.
double NoiseFactor(const std::deque<double>& errors) {
  return std::clamp(RobustSigma(errors), kMinNoiseFactor, kMaxNoiseFactor);
}

Eigen::Vector3d Difference(const Pose2& a, const Pose2& b) {
  return {a.x - b.x, a.y - b.y, WrapAngle(a.yaw - b.yaw)};
}

}  // namespace

WheelCalibrator::WheelCalibrator(const WheelModel& first) : first_(first), model_(first) {
  Vector sigmas;
  sigmas << first.scale.sigma, first.turn_scale.sigma, first.gyro_bias_rad_s.sigma,
      first.late_s.sigma, first.gyro_late_s.sigma;
  covariance_ = sigmas.cwiseAbs2().asDiagonal();
}

WheelCalibrator::Vector WheelCalibrator::Values(const WheelModel& model) {
  Vector values;
  values << model.scale.value, model.turn_scale.value, model.gyro_bias_rad_s.value,
      model.late_s.value, model.gyro_late_s.value;
  return values;
}

WheelModel WheelCalibrator::With(const Vector& values) const {
  WheelModel model = model_;
  const auto sigma = [this](int i) { return std::sqrt(covariance_(i, i)); };
  model.scale = {values[0], sigma(0)};
  model.turn_scale = {values[1], sigma(1)};
  model.gyro_bias_rad_s = {values[2], sigma(2)};
  model.late_s = {values[3], sigma(3)};
  model.gyro_late_s = {values[4], sigma(4)};
  return model;
}

bool WheelCalibrator::Place(double stamp_s,
                            const std::optional<PoseWithCovariance>& pose,
                            const DeadReckoning& wheels,
                            const std::optional<Twist2>& velocity) {
  // What is compared is the motion of the axle, to which the constants belong.
  const Pose2 T_base_axle = wheels.T_base_axle();
  std::optional<PoseWithCovariance> axle;
  if (pose) {
    axle.emplace(PoseWithCovariance{
        pose->pose * T_base_axle,
        ComposeCovariance(pose->pose, pose->covariance, T_base_axle, Eigen::Matrix3d::Zero())});
  }
  std::optional<Twist2> axle_velocity = velocity;
  if (velocity) axle_velocity->linear_m_s.y() += velocity->yaw_rad_s * T_base_axle.x;
  return Arrive(stamp_s, axle, wheels, axle_velocity, Seen::kPose);
}

bool WheelCalibrator::PlaceHeading(double stamp_s,
                                   const std::optional<HeadingPrior>& heading,
                                   const DeadReckoning& wheels,
                                   const std::optional<Twist2>& velocity) {
  std::optional<PoseWithCovariance> pose;
  if (heading) {
    pose.emplace();
    pose->pose.yaw = heading->heading_rad;
    pose->covariance(2, 2) = heading->variance_rad2;
  }
  return Arrive(stamp_s, pose, wheels, velocity, Seen::kHeading);
}

bool WheelCalibrator::Arrive(double stamp_s,
                             const std::optional<PoseWithCovariance>& pose,
                             const DeadReckoning& wheels,
                             const std::optional<Twist2>& velocity,
                             Seen seen) {
  if (!pose) {
    start_.reset();
    latest_.reset();
    slipping_ = false;
    return false;
  }
  Start now{stamp_s, *pose, velocity};
  if (!velocity && latest_) now.velocity = SeenVelocity(*latest_, stamp_s, pose->pose);
  latest_ = now;
  if (!start_) {
    start_ = now;
    return false;
  }
  const Pose2 T_from_to = start_->pose.pose.Inverse() * pose->pose;
  const double elapsed_s = stamp_s - start_->stamp_s;
  if (T_from_to.Translation().norm() < kPieceM && std::abs(T_from_to.yaw) < kPieceRad &&
      elapsed_s < kPieceS) {
    return false;
  }
  // The first images after a gap in time, or a slow recording, show nothing of the delays.
  Eigen::Matrix3d measured = start_->pose.covariance + pose->covariance;
  measured.diagonal() += Eigen::Vector3d(
      kSeenSigmaM * kSeenSigmaM, kSeenSigmaM * kSeenSigmaM, kSeenSigmaRad * kSeenSigmaRad);
  const bool taken = Take(now, measured, wheels, seen);
  start_ = now;
  return taken;
}

/// Of the robot when it arrived at a pose; nothing after a gap.
std::optional<Twist2> WheelCalibrator::SeenVelocity(const Start& before,
                                                    double stamp_s,
                                                    const Pose2& pose) {
  constexpr double kLongest = 0.3;
  const double elapsed_s = stamp_s - before.stamp_s;
  if (!(elapsed_s > 0 && elapsed_s <= kLongest)) return std::nullopt;
  return Twist2::Mean(before.pose.pose.Inverse() * pose, elapsed_s);
}

/// How the motion that the wheels report depends on the constants, by the motion that is seen. By
/// the reported one, its noise would count as motion too: scales would be too small (errors in
/// variables) and delays seem to be known at an even speed.
WheelCalibrator::Jacobian WheelCalibrator::Derivatives(const Start& now, bool by_gyro) const {
  const Pose2 T = start_->pose.pose.Inverse() * now.pose.pose;
  Jacobian J = Jacobian::Zero();
  J.col(0) << T.Translation() / model_.scale.value, 0;
  // The chord of an arc turns by half of the angle.
  const Eigen::Vector3d turned(-0.5 * T.y, 0.5 * T.x, 1);
  if (by_gyro) {
    J.col(2) = -(now.stamp_s - start_->stamp_s) * turned;
  } else {
    J.col(1) = T.yaw / model_.turn_scale.value * turned;
  }
  // A delay shifts both ends of the piece along the way.
  if (!start_->velocity || !now.velocity) return J;
  const Twist2& first = *start_->velocity;
  const Twist2& last = *now.velocity;
  const double turn_rate = T.yaw / (now.stamp_s - start_->stamp_s);
  J.col(3).head<2>() =
      T.Rotation() * last.linear_m_s - first.linear_m_s + turn_rate * Eigen::Vector2d(T.y, -T.x);
  J(2, by_gyro ? 4 : 3) = last.yaw_rad_s - first.yaw_rad_s;
  return J;
}

std::optional<RelativeMotion> WheelCalibrator::Reported(double from_s,
                                                        double to_s,
                                                        const DeadReckoning& wheels,
                                                        Seen seen) const {
  if (seen == Seen::kPose) return wheels.AxleBetween(from_s, to_s, model_);
  const std::optional<RelativeTurn> turn = wheels.TurnBetween(from_s, to_s, model_);
  if (!turn) return std::nullopt;
  RelativeMotion motion;
  motion.T_before_now.yaw = turn->turn_rad;  // not wrapped: its size tells a wrong unit
  motion.noise(2, 2) = turn->noise_rad2;
  return motion;
}

bool WheelCalibrator::Take(const Start& now,
                           const Eigen::Matrix3d& measured,
                           const DeadReckoning& wheels,
                           Seen seen) {
  const double from_s = start_->stamp_s;
  const double to_s = now.stamp_s;
  const std::optional<RelativeMotion> motion = Reported(from_s, to_s, wheels, seen);
  if (!motion) return false;
  const Pose2 T_from_to = start_->pose.pose.Inverse() * now.pose.pose;
  // Of (x, y, yaw), or of the yaw alone.
  const Eigen::Index rows = seen == Seen::kPose ? 3 : 1;
  const std::optional<RelativeTurn> turn = wheels.TurnBetween(from_s, to_s, model_);
  const bool by_gyro = turn && !turn->may_slip;
  const Eigen::MatrixXd J = Derivatives(now, by_gyro).bottomRows(rows);
  ++pieces_;
  Count(T_from_to, motion->T_before_now);
  travel_m_ += motion->travel_m;
  covariance_(2, 2) += kBiasWalk * kBiasWalk * (to_s - from_s);
  const Eigen::VectorXd difference = Difference(T_from_to, motion->T_before_now).tail(rows);
  const Eigen::MatrixXd noise = (motion->noise + measured).bottomRightCorner(rows, rows);
  const Eigen::MatrixXd S = J * covariance_ * J.transpose() + noise;
  if (difference.dot(S.ldlt().solve(difference)) > kMaxSigmas * kMaxSigmas) {
    ++slips_;
    if (seen == Seen::kPose) LearnSlip(difference.head<2>());
    return seen == Seen::kPose;
  }
  slipping_ = false;
  LearnNoise(difference, S.diagonal(), by_gyro);
  const Eigen::MatrixXd K = S.ldlt().solve(J * covariance_).transpose();
  const Vector values = Values(model_) + K * difference;
  Matrix left = Matrix::Identity() - K * J;
  covariance_ = left * covariance_ * left.transpose() + K * noise * K.transpose();
  model_ = With(values);
  if (seen == Seen::kPose && by_gyro) {
    // With the noise as it was stated: its own part in it is learned last.
    WheelModel stated = model_;
    stated.yaw_noise_per_sqrt_m = first_.yaw_noise_per_sqrt_m;
    stated.yaw_noise_per_sqrt_rad = first_.yaw_noise_per_sqrt_rad;
    const std::optional<RelativeTurn> by_wheels = wheels.WheelTurnBetween(from_s, to_s, stated);
    if (by_wheels) LearnTurnScale(T_from_to.yaw, *by_wheels, measured(2, 2));
  }
  return true;
}

/// @param difference  of a piece that contradicts the wheels, m.
void WheelCalibrator::LearnSlip(const Eigen::Vector2d& difference) {
  if (!slipping_) {
    ++slip_events_;
    slip_squares_ += slip_.squaredNorm();
    slip_.setZero();
  }
  slipping_ = true;
  slip_ += difference;
  slip_sum_ += difference;
  if (!(travel_m_ > 0)) return;
  const double per_m = (1 + 1.0 / slip_events_) / travel_m_;
  model_.slips = {per_m * slip_sum_.norm(),
                  std::sqrt(per_m * (slip_squares_ + slip_.squaredNorm()))};
}

/// The wheels' turn beside a gyro, which leaves it out of the motion: their scale depends on no
/// other constant then.
/// @param seen_rad2  variance of the turn that is seen.
void WheelCalibrator::LearnTurnScale(double seen_rad,
                                     const RelativeTurn& by_wheels,
                                     double seen_rad2) {
  const double J = seen_rad / model_.turn_scale.value;
  const double difference = WrapAngle(seen_rad - by_wheels.turn_rad);
  const double noise = by_wheels.noise_rad2 + seen_rad2;
  const double S = J * covariance_(1, 1) * J + noise;
  if (difference * difference > kMaxSigmas * kMaxSigmas * S) return;
  LearnYawNoise(difference / std::sqrt(S), /*by_gyro=*/false);
  const double K = covariance_(1, 1) * J / S;
  covariance_(1, 1) *= 1 - K * J;
  model_.turn_scale = {model_.turn_scale.value + K * difference, std::sqrt(covariance_(1, 1))};
}

/// The noise that wheels and gyro really have, as a multiple of what was stated.
/// @param difference, expected  variances; of (x, y, yaw), or of the yaw alone.
/// @param by_gyro  The yaw is that of the gyro.
void WheelCalibrator::LearnNoise(const Eigen::VectorXd& difference,
                                 const Eigen::VectorXd& expected,
                                 bool by_gyro) {
  const auto in_sigmas = [&](Eigen::Index row) {
    return difference[row] / std::sqrt(expected[row]);
  };
  const Eigen::Index yaw_row = difference.size() - 1;
  if (yaw_row > 0) {
    const double now = model_.travel_noise_per_sqrt_m / first_.travel_noise_per_sqrt_m;
    Keep(now * in_sigmas(0), travel_errors_);
    if (travel_errors_.size() >= kFewestPieces) {
      model_.travel_noise_per_sqrt_m = NoiseFactor(travel_errors_) * first_.travel_noise_per_sqrt_m;
    }
  }
  const double now = by_gyro ? model_.gyro_noise_per_sqrt_s / first_.gyro_noise_per_sqrt_s
                             : model_.yaw_noise_per_sqrt_m / first_.yaw_noise_per_sqrt_m;
  LearnYawNoise(now * in_sigmas(yaw_row), by_gyro);
}

/// @param error  of a piece, standard deviations as stated at first.
void WheelCalibrator::LearnYawNoise(double error, bool by_gyro) {
  std::deque<double>& errors = by_gyro ? gyro_errors_ : yaw_errors_;
  Keep(error, errors);
  if (errors.size() < kFewestPieces) return;
  const double yaw = NoiseFactor(errors);
  if (by_gyro) {
    model_.gyro_noise_per_sqrt_s = yaw * first_.gyro_noise_per_sqrt_s;
  } else {
    model_.yaw_noise_per_sqrt_m = yaw * first_.yaw_noise_per_sqrt_m;
    model_.yaw_noise_per_sqrt_rad = yaw * first_.yaw_noise_per_sqrt_rad;
  }
}

void WheelCalibrator::Count(const Pose2& seen, const Pose2& reported) {
  travel_both_ += seen.Translation().dot(reported.Translation());
  travel_reported_ += reported.Translation().squaredNorm();
  turn_both_ += seen.yaw * reported.yaw;
  turn_reported_ += reported.yaw * reported.yaw;
  turn_seen_ += seen.yaw * seen.yaw;
}

double WheelCalibrator::TravelRatio() const {
  return travel_reported_ > 0 ? travel_both_ / travel_reported_ : 0;
}

double WheelCalibrator::TurnRatio() const {
  return turn_reported_ > 0 ? turn_both_ / turn_reported_ : 0;
}

WheelFault WheelCalibrator::Fault() const {
  constexpr std::int64_t kFewest = 20;
  constexpr double kTurningRad = 0.05;  // RMS of a piece
  constexpr double kAlike = 0.3;        // of turns seen and reported
  const auto pieces = static_cast<double>(pieces_);
  const bool turns = turn_seen_ > pieces * kTurningRad * kTurningRad;
  const bool unlike = turns && TurnRatio() < kAlike;
  if (pieces_ < kFewest || (2 * slips_ < pieces_ && !unlike)) return WheelFault::kNone;
  constexpr double kOpposite = -0.5;
  if (travel_reported_ > 0) {  // else only headings were seen
    const double travel = TravelRatio();
    constexpr double kUnits = 3;
    if (std::abs(travel) > kUnits || (std::abs(travel) * kUnits < 1 && !unlike)) {
      return WheelFault::kUnits;
    }
    if (travel < kOpposite) return WheelFault::kOppositeTravel;
  }
  if (TurnRatio() < kOpposite) return WheelFault::kOppositeYaw;
  constexpr double kTurnUnits = 0.05;
  if (turns && TurnRatio() > 0 && TurnRatio() < kTurnUnits) return WheelFault::kTurnUnits;
  return WheelFault::kUnrelated;
}

}  // namespace ceilmap::wheels
