#include "calib/base/planar_fit.hpp"

#include <cmath>

namespace ceilmap {

std::optional<PlanarFit> FitPlane(std::span<const PointPair> pairs, bool estimate_scale) {
  PlanarFit fit;
  Eigen::Vector2d centre_a = Eigen::Vector2d::Zero();
  for (const PointPair& pair : pairs) {
    fit.weights += pair.weight;
    centre_a += pair.weight * pair.p_a;
    fit.centre_b += pair.weight * pair.p_b;
  }
  if (pairs.size() < 2) return std::nullopt;
  centre_a /= fit.weights;
  fit.centre_b /= fit.weights;

  double dot = 0;
  double cross = 0;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector2d a = pair.p_a - centre_a;
    const Eigen::Vector2d b = pair.p_b - fit.centre_b;
    dot += pair.weight * b.dot(a);
    cross += pair.weight * (b.x() * a.y() - b.y() * a.x());
    fit.moment_b += pair.weight * b.squaredNorm();
  }
  const double length = std::hypot(dot, cross);
  if (!(fit.moment_b > 0) || !(length > 0)) return std::nullopt;
  fit.S_a_b.scale = estimate_scale ? length / fit.moment_b : 1;
  fit.S_a_b.motion.yaw = WrapAngle(std::atan2(cross, dot));
  const Eigen::Vector2d t =
      centre_a - fit.S_a_b.scale * (fit.S_a_b.motion.Rotation() * fit.centre_b);
  fit.S_a_b.motion.x = t.x();
  fit.S_a_b.motion.y = t.y();
  return fit;
}

}  // namespace ceilmap
