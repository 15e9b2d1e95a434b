#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "calib/base/similarity2.hpp"

/// Least-squares transforms between two sets of points of the plane.
namespace ceilmap {

/// p_a = S_a_b * p_b, counted with a weight > 0.
struct PointPair {
  Eigen::Vector2d p_a;
  Eigen::Vector2d p_b;
  double weight = 1;
};

struct PlanarFit {
  Similarity2 S_a_b;
  Eigen::Vector2d centre_b = Eigen::Vector2d::Zero();  ///< weighted mean of p_b
  double weights = 0;                                  ///< sum
  double moment_b = 0;                                 ///< weighted sum of |p_b - centre_b|^2
};

/// The transform of least weighted squares, in closed form (Umeyama 1991, "Least-squares estimation
/// of transformation parameters between two point patterns", in the plane).
/// @param estimate_scale  false: scale 1.
/// @return nothing where the points do not determine it: fewer than two of them, or all in one
/// place in a or in b.
std::optional<PlanarFit> FitPlane(std::span<const PointPair> pairs, bool estimate_scale);

}  // namespace ceilmap
