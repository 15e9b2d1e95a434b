#include "app/evaluation/alignment.hpp"

#include <cmath>

namespace ceilmap::evaluation {
namespace {

// Sums over points relative to their means.
struct Moments {
  Eigen::Vector2d mean_truth = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean_estimate = Eigen::Vector2d::Zero();
  double cross = 0;    // of estimate x truth
  double dot = 0;      // of estimate . truth
  double squares = 0;  // of |estimate|^2
};

Moments Collect(const std::vector<PointPair>& pairs) {
  Moments m;
  for (const PointPair& pair : pairs) {
    m.mean_truth += pair.truth;
    m.mean_estimate += pair.estimate;
  }
  m.mean_truth /= static_cast<double>(pairs.size());
  m.mean_estimate /= static_cast<double>(pairs.size());
  for (const PointPair& pair : pairs) {
    const Eigen::Vector2d s = pair.estimate - m.mean_estimate;
    const Eigen::Vector2d d = pair.truth - m.mean_truth;
    m.cross += s.x() * d.y() - s.y() * d.x();
    m.dot += s.dot(d);
    m.squares += s.squaredNorm();
  }
  return m;
}

PlanarSimilarity Solve(const Moments& m, double scale) {
  PlanarSimilarity T{{0, 0, std::atan2(m.cross, m.dot)}, scale};
  const Eigen::Vector2d t = m.mean_truth - scale * (T.motion.Rotation() * m.mean_estimate);
  T.motion.x = t.x();
  T.motion.y = t.y();
  return T;
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

Eigen::Vector2d operator*(const PlanarSimilarity& T, const Eigen::Vector2d& p) {
  return T.motion * (T.scale * p);
}

StampedPose operator*(const PlanarSimilarity& T, const StampedPose& pose) {
  StampedPose moved = pose;
  moved.position << T * Eigen::Vector2d(pose.position.head<2>()), T.scale * pose.position.z();
  const double half = T.motion.yaw / 2;
  moved.orientation = Eigen::Quaterniond(std::cos(half), 0, 0, std::sin(half)) * pose.orientation;
  return moved;
}

Pose2 FitPlanarMotion(const std::vector<PointPair>& pairs) {
  return Solve(Collect(pairs), 1).motion;
}

PlanarSimilarity FitPlanarSimilarity(const std::vector<PointPair>& pairs) {
  const Moments m = Collect(pairs);
  const double together = std::hypot(m.cross, m.dot);
  return Solve(m, together > 0 && m.squares > 0 ? together / m.squares : 1);
}

PlanarSimilarity Align(const std::vector<PosePair>& pairs, Alignment alignment) {
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
