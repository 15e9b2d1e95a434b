#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "app/evaluation/trajectory_errors.hpp"

namespace ceilmap::evaluation {

/// Consistency of an estimate's errors with its covariances. The normalized estimation error
/// squared (NEES, Bar-Shalom et al. 2001, "Estimation with applications to tracking and
/// navigation", 5.4) e^T P^-1 e has the expectation n and follows the chi-squared distribution with
/// n degrees of freedom when the n errors e are Gaussian with the covariance P. If the mean is
/// above n, the estimate is overconfident.
struct Nees {
  double mean = 0;
  double expected = 0;   ///< n
  double median = 0;     ///< less sensitive to a few gross errors
  double inside_95 = 0;  ///< fraction of the frames inside the 95 % region, in [0, 1]
};

struct Consistency {
  std::int64_t frames = 0;  ///< matched, with an invertible covariance
  Nees position;            ///< x, y
  Nees pose;                ///< x, y, yaw
};

/// Covariance of (x, y, yaw) of one pose, metres and radians, in the frame of the estimate; unset:
/// unknown.
using PoseCovariance = std::optional<Eigen::Matrix3d>;

/// Consistency of the errors that remain after the alignment. An alignment that was fitted to this
/// estimate (Alignment::kSe2) removes a part of them, which is small in a long drive.
/// @param errors  Errors of the estimate.
/// @param covariances  One for each of its poses.
/// @return unset when no matched pose has a covariance.
std::optional<Consistency> MeasureConsistency(const TrajectoryErrors& errors,
                                              const std::vector<PoseCovariance>& covariances);

}  // namespace ceilmap::evaluation
