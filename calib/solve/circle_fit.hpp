#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace ceilmap::calibration {

/// A circle through points, most of which lie on it.
struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;
};

struct CircleFit {
  Circle circle;
  /// Of (centre u, centre v, radius), from the residuals; neighbours on the circle within 10
  /// degrees are taken for dependent.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double sigma = 0;          ///< robust deviation of a point from the circle
  double inlier_ratio = 0;   ///< within three of them
  std::vector<bool> inlier;  ///< of each point
};

/// The circle that has the most points within `tolerance`, among those through triples of them (a
/// fixed series: the same points give the same circle).
std::optional<Circle> FindCircle(const std::vector<Eigen::Vector2d>& points, double tolerance);

/// Least squares of the distances from the circle, with Tukey's biweight on a robust scale, from a
/// start that is nearly right. @return nothing with fewer than 8 points or where they do not tell.
std::optional<CircleFit> FitCircle(const std::vector<Eigen::Vector2d>& points, const Circle& start);

}  // namespace ceilmap::calibration
