#include "compensation/mount/wheel_motion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/base/degrees.hpp"
#include "calib/base/statistics.hpp"

namespace ceilmap::mount {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr std::size_t kMinSteps = 5;
constexpr double kMedianOfNormal = 0.6745;

double RobustSigma(const VectorXd& errors) {
  std::vector<double> sizes;
  for (const double error : errors) sizes.push_back(std::abs(error));
  return Median(sizes) / kMedianOfNormal;
}

struct LinearFit {
  VectorXd values;
  MatrixXd covariance;
  double sigma = 0;
};

// Least squares of A x = b with Cauchy's weights.
LinearFit FitRobustly(const MatrixXd& A, const VectorXd& b, double least_sigma) {
  constexpr double kCauchyScale = 2.3849;
  constexpr int kRounds = 8;
  LinearFit fit;
  VectorXd weights = VectorXd::Ones(b.size());
  for (int round = 0; round < kRounds; ++round) {
    const MatrixXd weighted = weights.asDiagonal() * A;
    const MatrixXd normal = A.transpose() * weighted;
    const Eigen::LDLT<MatrixXd> solver(normal);
    fit.values = solver.solve(weighted.transpose() * b);
    const VectorXd errors = A * fit.values - b;
    fit.sigma = std::max(least_sigma, RobustSigma(errors));
    fit.covariance =
        fit.sigma * fit.sigma * solver.solve(MatrixXd::Identity(normal.rows(), normal.cols()));
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      const double ratio = errors[i] / (kCauchyScale * fit.sigma);
      weights[i] = 1 / (1 + ratio * ratio);
    }
  }
  return fit;
}

Measured ValueOf(const LinearFit& fit, Eigen::Index i) {
  return {fit.values[i], std::sqrt(std::max(0.0, fit.covariance(i, i)))};
}

double Lever(const DriveStep& step) {
  return 2 * std::sin(step.turn_rad / 2);
}

// Sideways motion of the axle is zero: with n across base x in the camera's axes,
//   n . moved - lever * ahead = 0.
struct SidewaysFit {
  double ahead = 0;
  double cost = std::numeric_limits<double>::infinity();
};

SidewaysFit SidewaysAt(const std::vector<DriveStep>& steps, double yaw_rad) {
  const auto n = static_cast<Eigen::Index>(steps.size());
  MatrixXd A(n, 1);
  VectorXd b(n);
  const Pose2 T_base_level{0, 0, yaw_rad};
  for (Eigen::Index i = 0; i < n; ++i) {
    const DriveStep& step = steps[static_cast<std::size_t>(i)];
    A(i, 0) = Lever(step);
    b[i] = (T_base_level * step.moved).y();
  }
  constexpr double kMin = 1e-4;
  const LinearFit fit = FitRobustly(A, b, kMin);
  SidewaysFit result{fit.values[0], 0};
  for (const double error : VectorXd(A * fit.values - b)) result.cost += std::abs(error);
  return result;
}

double BestYaw(const std::vector<DriveStep>& steps) {
  double best = 0;
  double cost = std::numeric_limits<double>::infinity();
  for (int deg = 0; deg < 180; ++deg) {
    const SidewaysFit fit = SidewaysAt(steps, deg * kRadPerDeg);
    if (fit.cost >= cost) continue;
    cost = fit.cost;
    best = deg * kRadPerDeg;
  }
  double ahead = 0;
  for (const DriveStep& step : steps) ahead += (Pose2{0, 0, best} * step.moved).x();
  return ahead < 0 ? best + kRadPerDeg * 180 : best;
}

}  // namespace

std::optional<WheelMotion> FitWheels(const std::vector<DriveStep>& steps) {
  if (steps.size() < kMinSteps) return std::nullopt;
  WheelMotion motion;
  double yaw = BestYaw(steps);
  const auto n = static_cast<Eigen::Index>(steps.size());
  MatrixXd A(n, 2);
  VectorXd b(n);
  LinearFit fit;
  constexpr int kRounds = 3;
  constexpr double kMin = 2e-5;
  for (int round = 0; round < kRounds; ++round) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const DriveStep& step = steps[static_cast<std::size_t>(i)];
      const Vector2d in_base = Pose2{0, 0, yaw} * step.moved;
      A(i, 0) = in_base.x();
      A(i, 1) = -Lever(step);
      b[i] = -in_base.y();
    }
    fit = FitRobustly(A, b, kMin);
    yaw += fit.values[0];
  }
  motion.yaw_rad = {WrapAngle(yaw), ValueOf(fit, 0).sigma};
  motion.ahead = ValueOf(fit, 1);
  std::vector<double> lengths;
  lengths.reserve(steps.size());
  for (const DriveStep& step : steps) {
    lengths.push_back(step.moved.norm());
  }
  motion.slip = fit.sigma / std::max(1e-9, Median(lengths));
  return motion;
}

namespace {

// Planar poses of the odometry at any time, with continuous headings.
class OdometryTrack {
 public:
  explicit OdometryTrack(const std::vector<StampedPose>& poses) {
    double heading = 0;
    for (const StampedPose& pose : poses) {
      Pose2 planar = PlanarPose(pose);
      heading += WrapAngle(planar.yaw - heading);
      planar.yaw = heading;
      stamps_s_.push_back(pose.stamp_s);
      poses_.push_back(planar);
    }
  }
  // Linear between poses, whose yaw is continuous. Nothing outside.
  [[nodiscard]] std::optional<Pose2> At(double stamp_s) const {
    const auto after = std::lower_bound(stamps_s_.begin(), stamps_s_.end(), stamp_s);
    if (after == stamps_s_.begin() || after == stamps_s_.end()) return std::nullopt;
    const auto i = static_cast<std::size_t>(after - stamps_s_.begin());
    const Pose2& from = poses_[i - 1];
    const Pose2& to = poses_[i];
    const double ratio = (stamp_s - stamps_s_[i - 1]) / (stamps_s_[i] - stamps_s_[i - 1]);
    return Pose2{from.x + ratio * (to.x - from.x),
                 from.y + ratio * (to.y - from.y),
                 from.yaw + ratio * (to.yaw - from.yaw)};
  }
  [[nodiscard]] std::optional<double> Turn(const DriveStep& step, double offset_s) const {
    const auto from = At(step.start_s + offset_s);
    const auto to = At(step.end_s + offset_s);
    if (!from || !to) return std::nullopt;
    return to->yaw - from->yaw;
  }

 private:
  std::vector<double> stamps_s_;
  std::vector<Pose2> poses_;
};

struct TurnCost {
  double mean = std::numeric_limits<double>::infinity();
  std::size_t steps = 0;
};

TurnCost CostOf(const std::vector<DriveStep>& steps,
                const OdometryTrack& track,
                double sign,
                double offset_s) {
  TurnCost cost;
  double sum = 0;
  for (const DriveStep& step : steps) {
    const auto turn = track.Turn(step, offset_s);
    if (!turn) continue;
    const double error = step.turn_rad - sign * *turn;
    sum += error * error;
    ++cost.steps;
  }
  if (cost.steps >= std::max(kMinSteps, steps.size() / 2)) {
    cost.mean = sum / static_cast<double>(cost.steps);
  }
  return cost;
}

struct Offset {
  double offset_s = 0;
  double sigma_s = 0;
  double cost = std::numeric_limits<double>::infinity();
};

// The least mean square difference of the turns.
Offset FindOffset(const std::vector<DriveStep>& steps, const OdometryTrack& track, double sign) {
  constexpr double kMaxS = 1;
  constexpr double kStepS = 0.005;
  Offset best;
  const int n = static_cast<int>(kMaxS / kStepS);
  for (int i = -n; i <= n; ++i) {
    const TurnCost cost = CostOf(steps, track, sign, i * kStepS);
    if (cost.mean < best.cost) best = {i * kStepS, 0, cost.mean};
  }
  if (!std::isfinite(best.cost)) return best;
  // A parabola over a wider interval, because odometry has steps of its own.
  constexpr double kWideS = 0.04;
  const double before = CostOf(steps, track, sign, best.offset_s - kWideS).mean;
  const double after = CostOf(steps, track, sign, best.offset_s + kWideS).mean;
  const double curvature = (before + after - 2 * best.cost) / (kWideS * kWideS);
  constexpr double kMinRad = 5e-4;  // of a turn, by a shift of kWideS
  const bool shows = before + after - 2 * best.cost > 2 * kMinRad * kMinRad;
  if (!std::isfinite(curvature) || !shows) return best;  // sigma 0: not determined
  best.offset_s -= std::clamp((after - before) / (2 * kWideS * curvature), -kWideS, kWideS);
  const auto count = static_cast<double>(CostOf(steps, track, sign, best.offset_s).steps);
  best.sigma_s = std::hypot(0.001, std::sqrt(2 * best.cost / (curvature * count)));
  return best;
}

}  // namespace

std::optional<OdometryFit> FitOdometry(const std::vector<DriveStep>& steps,
                                       const std::vector<StampedPose>& odometry) {
  constexpr double kMinSpinRad = 60 * kRadPerDeg;
  double turned = 0;
  for (const DriveStep& step : steps) turned += std::abs(step.turn_rad);
  if (steps.size() < kMinSteps || turned < kMinSpinRad || odometry.size() < kMinSteps) {
    return std::nullopt;
  }
  const OdometryTrack track(odometry);
  const Offset straight = FindOffset(steps, track, 1);
  const Offset mirrored = FindOffset(steps, track, -1);
  OdometryFit fit;
  fit.mirrored = mirrored.cost < straight.cost;
  const Offset& offset = fit.mirrored ? mirrored : straight;
  if (!std::isfinite(offset.cost)) return std::nullopt;
  // At a constant rate of turning, any offset fits.
  constexpr double kMaxSigmaS = 0.02;
  if (offset.sigma_s > 0 && offset.sigma_s < kMaxSigmaS) {
    fit.late_s = Measured{-offset.offset_s, offset.sigma_s};
  }
  // distance * R(yaw) * moved + lever * (c_y, -c_x) = moved by the odometry.
  std::vector<Eigen::RowVector4d> rows;
  std::vector<double> right;
  for (const DriveStep& step : steps) {
    const auto from = track.At(step.start_s + offset.offset_s);
    const auto to = track.At(step.end_s + offset.offset_s);
    if (!from || !to) continue;
    const Vector2d moved =
        Pose2{0, 0, -0.5 * (from->yaw + to->yaw)} * Vector2d(to->x - from->x, to->y - from->y);
    const double lever = Lever(step);
    rows.push_back({step.moved.x(), -step.moved.y(), 0, lever});
    right.push_back(moved.x());
    rows.push_back({step.moved.y(), step.moved.x(), -lever, 0});
    right.push_back(moved.y());
  }
  MatrixXd A(static_cast<Eigen::Index>(rows.size()), 4);
  for (std::size_t i = 0; i < rows.size(); ++i) A.row(static_cast<Eigen::Index>(i)) = rows[i];
  constexpr double kMinM = 1e-4;
  const LinearFit linear = FitRobustly(
      A, Eigen::Map<const VectorXd>(right.data(), static_cast<Eigen::Index>(right.size())), kMinM);
  const double distance = std::hypot(linear.values[0], linear.values[1]);
  fit.distance_m = {distance, ValueOf(linear, 0).sigma};
  fit.yaw_rad = {std::atan2(linear.values[1], linear.values[0]),
                 ValueOf(linear, 1).sigma / std::max(1e-9, distance)};
  return fit;
}

}  // namespace ceilmap::mount
