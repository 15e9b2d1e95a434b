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
  /// degrees are taken as correlated.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double sigma = 0;          ///< robust standard deviation of a point from the circle
  double inlier_ratio = 0;   ///< within three standard deviations
  std::vector<bool> inlier;  ///< of each point
};

/// The circle with the most points within `tolerance`, among circles through triples of points (a
/// fixed sequence: the same points give the same circle).
std::optional<Circle> FindCircle(const std::vector<Eigen::Vector2d>& points, double tolerance);

/// Least squares of the distances from the circle, with Tukey's biweight on a robust scale, from an
/// approximate start. @return nothing with fewer than 8 points or when they do not determine a
/// circle.
std::optional<CircleFit> FitCircle(const std::vector<Eigen::Vector2d>& points, const Circle& start);

}  // namespace ceilmap::calibration
