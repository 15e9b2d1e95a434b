#pragma once

#include <Eigen/Core>
#include <vector>

#include "app/evaluation/pose_errors.hpp"
#include "calib/base/pose2.hpp"
#include "calib/base/stamped_pose.hpp"

namespace ceilmap::evaluation {

/// How an estimate is transformed into the frame of the truth before positions are compared.
/// Heights, pitch and roll are not changed, because a map is a plane.
enum class Alignment {
  kNone,   ///< no alignment: both are in one frame already
  kFirst,  ///< the first matched poses coincide
  kSe2,    ///< the rigid planar motion with the least squared position error; no scale
  kSim2,   ///< the same with a scale
};

/// A planar similarity: p_truth = scale * R(yaw) * p_estimate + t.
struct PlanarSimilarity {
  Pose2 motion;      ///< R(yaw) and t
  double scale = 1;  ///< > 0
};
Eigen::Vector2d operator*(const PlanarSimilarity& T, const Eigen::Vector2d& p);
/// Rotates and translates the pose; its height is multiplied by the scale.
StampedPose operator*(const PlanarSimilarity& T, const StampedPose& pose);

/// A point in the truth and the same point in an estimate.
struct PointPair {
  Eigen::Vector2d truth;
  Eigen::Vector2d estimate;
};

/// The planar motion that minimises the sum of |truth - T estimate|^2; no scale.
/// @param pairs  At least one. If all points coincide the rotation is 0.
Pose2 FitPlanarMotion(const std::vector<PointPair>& pairs);

/// The same with a scale (Umeyama 1991, "Least-squares estimation of transformation parameters
/// between two point patterns", in the plane). The scale is 1 where the truth or the estimate does
/// not move.
PlanarSimilarity FitPlanarSimilarity(const std::vector<PointPair>& pairs);

/// @param pairs  At least one.
PlanarSimilarity Align(const std::vector<PosePair>& pairs, Alignment alignment);

}  // namespace ceilmap::evaluation
