#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "app/evaluation/trajectory_errors.hpp"

namespace ceilmap::evaluation {

/// Does an estimate err as much as its covariances say? The normalized estimation error squared
/// (NEES, Bar-Shalom et al. 2001, "Estimation with applications to tracking and navigation", 5.4)
/// e^T P^-1 e has the expectation n and follows the chi-squared distribution of n degrees of
/// freedom when the n errors e are Gaussian with the covariance P. A mean above n: too sure of
/// itself.
struct Nees {
  double mean = 0;
  double expected = 0;   ///< n
  double median = 0;     ///< sturdier against a few gross errors
  double inside_95 = 0;  ///< part of the frames inside the 95 % region, in [0, 1]
};

struct Consistency {
  std::int64_t frames = 0;  ///< matched, with a covariance that can be inverted
  Nees position;            ///< x, y
  Nees pose;                ///< x, y, yaw
};

/// Covariance of (x, y, yaw) of one pose, metres and radians, in the frame of the estimate; unset:
/// not known.
using PoseCovariance = std::optional<Eigen::Matrix3d>;

/// Of the errors that remain after the alignment; one that was fitted to this very estimate
/// (Alignment::kSe2) takes a part of them away, which weighs little in a long drive.
/// @param errors  of the estimate.
/// @param covariances  of all its poses, as many as it has.
/// @return unset when no matched pose has a covariance.
std::optional<Consistency> MeasureConsistency(const TrajectoryErrors& errors,
                                              const std::vector<PoseCovariance>& covariances);

}  // namespace ceilmap::evaluation
