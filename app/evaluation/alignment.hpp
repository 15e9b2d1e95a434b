#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

#include "app/evaluation/stamped_pose.hpp"
#include "calib/pose2.hpp"

namespace ceilmap::evaluation {

/// Positions (truth, estimate) of poses nearest in time: each estimate goes to the nearest truth
/// that is within max_dt_s, each truth takes one. By rising stamps.
/// @param truth, estimate  stamps strictly increasing.
std::vector<std::pair<std::size_t, std::size_t>> MatchStamps(
    const std::vector<StampedPose>& truth,
    const std::vector<StampedPose>& estimate,
    double max_dt_s);

/// Length of the way over the floor from the first pose to each, in metres.
std::vector<double> PathLengths(const std::vector<StampedPose>& poses);

/// A point of the truth, and where an estimate has it.
struct PointPair {
  Eigen::Vector2d truth;
  Eigen::Vector2d estimate;
};

/// The planar motion that minimises the sum of |truth - T estimate|^2; no scale.
/// @param pairs  at least one; of points that all coincide the rotation is 0.
calib::Pose2 FitPlanarMotion(const std::vector<PointPair>& pairs);

}  // namespace ceilmap::evaluation
