#include "app/evaluation/alignment.hpp"

#include <cmath>

namespace ceilmap::evaluation {
namespace {

/// Points that do not determine a rotation are only moved.
Similarity2 FitOrMove(const std::vector<PointPair>& pairs, bool estimate_scale) {
  if (const auto fit = FitPlane(pairs, estimate_scale)) return fit->S_a_b;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const PointPair& pair : pairs) sum += pair.p_a - pair.p_b;
  const Eigen::Vector2d t = sum / static_cast<double>(pairs.size());
  return {{t.x(), t.y(), 0}, 1};
}

std::vector<PointPair> Positions(const std::vector<PosePair>& pairs) {
  std::vector<PointPair> points;
  points.reserve(pairs.size());
  for (const PosePair& pair : pairs) {
    points.push_back({pair.truth.position.head<2>(), pair.estimate.position.head<2>()});
  }
  return points;
}

}  // namespace

StampedPose operator*(const Similarity2& T, const StampedPose& pose) {
  StampedPose moved = pose;
  moved.position << T * Eigen::Vector2d(pose.position.head<2>()), T.scale * pose.position.z();
  const double half = T.motion.yaw / 2;
  moved.orientation = Eigen::Quaterniond(std::cos(half), 0, 0, std::sin(half)) * pose.orientation;
  return moved;
}

Pose2 FitPlanarMotion(const std::vector<PointPair>& pairs) {
  return FitOrMove(pairs, false).motion;
}

Similarity2 FitPlanarSimilarity(const std::vector<PointPair>& pairs) {
  return FitOrMove(pairs, true);
}

Similarity2 Align(const std::vector<PosePair>& pairs, Alignment alignment) {
  switch (alignment) {
    case Alignment::kSe2:
      return {FitPlanarMotion(Positions(pairs)), 1};
    case Alignment::kSim2:
      return FitPlanarSimilarity(Positions(pairs));
    case Alignment::kFirst:
      return {PlanarPose(pairs.front().truth) * PlanarPose(pairs.front().estimate).Inverse(), 1};
    case Alignment::kNone:
      break;
  }
  return {};
}

}  // namespace ceilmap::evaluation
