#include "app/evaluation/consistency.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

#include "calib/base/degrees.hpp"
#include "calib/base/pose2.hpp"

namespace ceilmap::evaluation {
namespace {

// 95 % quantiles of the chi-squared distribution with two and with three degrees of freedom.
constexpr double kChi2Of2 = 5.991464547107979;
constexpr double kChi2Of3 = 7.814727903251179;

// e^T P^-1 e; unset when P is not invertible.
template <int kSize>
std::optional<double> NormalizedSquare(const Eigen::Matrix<double, kSize, 1>& error,
                                       const Eigen::Matrix<double, kSize, kSize>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, kSize, kSize>> factor(covariance);
  if (!covariance.allFinite() || factor.info() != Eigen::Success) return std::nullopt;
  return error.dot(factor.solve(error));
}

Nees Summarize(std::vector<double> values, int freedom, double bound) {
  Nees nees;
  std::int64_t inside = 0;
  for (const double value : values) inside += value <= bound ? 1 : 0;
  nees.expected = freedom;
  nees.inside_95 = static_cast<double>(inside) / static_cast<double>(values.size());
  const ErrorStatistics statistics = Statistics(std::move(values));
  nees.mean = statistics.mean;
  nees.median = statistics.median;
  return nees;
}

}  // namespace

std::optional<Consistency> MeasureConsistency(const TrajectoryErrors& errors,
                                              const std::vector<PoseCovariance>& covariances) {
  const Similarity2& T = errors.T_truth_estimate;
  const Eigen::Matrix2d R_estimate_truth = T.motion.Rotation().transpose();
  std::vector<double> position;
  std::vector<double> pose;
  for (const FrameError& frame : errors.frames) {
    const PoseCovariance& covariance = covariances.at(frame.estimate);
    if (!covariance) continue;
    Eigen::Vector3d error;  // in the frame of the covariance
    error << R_estimate_truth * frame.shift_m / T.scale, kRadPerDeg * frame.yaw_deg;
    const auto of_position =
        NormalizedSquare<2>(error.head<2>(), covariance->topLeftCorner<2, 2>());
    const auto of_pose = NormalizedSquare<3>(error, *covariance);
    if (!of_position || !of_pose) continue;
    position.push_back(*of_position);
    pose.push_back(*of_pose);
  }
  if (position.empty()) return std::nullopt;
  Consistency consistency;
  consistency.frames = static_cast<std::int64_t>(position.size());
  consistency.position = Summarize(std::move(position), 2, kChi2Of2);
  consistency.pose = Summarize(std::move(pose), 3, kChi2Of3);
  return consistency;
}

}  // namespace ceilmap::evaluation
