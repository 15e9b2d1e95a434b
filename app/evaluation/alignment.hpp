#pragma once

#include <Eigen/Core>
#include <vector>

#include "app/evaluation/pose_errors.hpp"
#include "calib/base/planar_fit.hpp"
#include "calib/base/similarity2.hpp"
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

/// Rotates and translates the pose; its height is multiplied by the scale.
StampedPose operator*(const Similarity2& T, const StampedPose& pose);

/// The planar motion that minimises the sum of |p_a - T_a_b p_b|^2; no scale.
/// @param pairs  At least one, without weights: a is the truth, b the estimate. If all points
/// coincide the rotation is 0.
Pose2 FitPlanarMotion(const std::vector<PointPair>& pairs);

/// The same with a scale. It is 1 where the truth or the estimate does not move.
Similarity2 FitPlanarSimilarity(const std::vector<PointPair>& pairs);

/// @param pairs  At least one.
Similarity2 Align(const std::vector<PosePair>& pairs, Alignment alignment);

}  // namespace ceilmap::evaluation
