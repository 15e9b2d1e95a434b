#include "calib/solve/circle_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>

namespace ceilmap::calibration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Circle> Through(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  Eigen::Matrix2d A;
  A.row(0) = (b - a).transpose();
  A.row(1) = (c - a).transpose();
  const double size = (b - a).norm() * (c - a).norm();
  if (!(std::abs(A.determinant()) > 1e-3 * size)) return std::nullopt;
  const Vector2d half(0.5 * (b - a).squaredNorm(), 0.5 * (c - a).squaredNorm());
  const Vector2d from_a = A.inverse() * half;
  return Circle{a + from_a, from_a.norm()};
}

double Residual(const Circle& circle, const Vector2d& point) {
  return (point - circle.centre).norm() - circle.radius;
}

double RobustSigma(const std::vector<Vector2d>& points, const Circle& circle) {
  std::vector<double> sizes;
  sizes.reserve(points.size());
  for (const Vector2d& point : points) sizes.push_back(std::abs(Residual(circle, point)));
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  constexpr double kMin = 1e-6;
  return std::max(kMin, *middle / 0.6745);
}

// Derivative of a residual by centre and radius.
Vector3d Slope(const Circle& circle, const Vector2d& point) {
  const Vector2d out = (point - circle.centre).normalized();
  return {-out.x(), -out.y(), -1};
}

double Weight(double residual, double sigma) {
  const double x = residual / (4.685 * sigma);
  return std::abs(x) < 1 ? (1 - x * x) * (1 - x * x) : 0;
}

struct CircleNormal {
  Matrix3d A = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
};

CircleNormal NormalOf(const std::vector<Vector2d>& points, const Circle& circle, double sigma) {
  CircleNormal normal;
  for (const Vector2d& point : points) {
    const double residual = Residual(circle, point);
    const Vector3d slope = Slope(circle, point);
    const double weight = Weight(residual, sigma);
    normal.A += weight * slope * slope.transpose();
    normal.b += weight * residual * slope;
  }
  return normal;
}

Matrix3d Spread(const std::vector<Vector2d>& points, const Circle& circle, double sigma) {
  constexpr std::size_t kSectors = 36;
  std::vector<Vector3d> pulls(kSectors, Vector3d::Zero());
  for (const Vector2d& point : points) {
    const Vector2d out = point - circle.centre;
    const double turn = std::atan2(out.y(), out.x()) / (2 * std::numbers::pi) + 0.5;
    const auto sector = std::min(kSectors - 1, static_cast<std::size_t>(turn * kSectors));
    const double residual = Residual(circle, point);
    pulls[sector] += Weight(residual, sigma) * residual * Slope(circle, point);
  }
  Matrix3d sum = Matrix3d::Zero();
  for (const Vector3d& pull : pulls) sum += pull * pull.transpose();
  const Matrix3d inverse = NormalOf(points, circle, sigma).A.inverse();
  // Three parameters were estimated from this number of sectors.
  constexpr double kFew = static_cast<double>(kSectors) / (kSectors - 3);
  return kFew * inverse * sum * inverse;
}

}  // namespace

std::optional<Circle> FindCircle(const std::vector<Vector2d>& points, double tolerance) {
  if (points.size() < 8) return std::nullopt;
  constexpr int kTriples = 500;
  std::mt19937 random(
      1);  // a generator with the same numbers on all platforms, unlike distributions
  const auto pick = [&] { return points[random() % points.size()]; };
  std::optional<Circle> best;
  std::ptrdiff_t most = 0;
  for (int k = 0; k < kTriples; ++k) {
    const Vector2d a = pick();
    const Vector2d b = pick();
    const Vector2d c = pick();
    const std::optional<Circle> circle = Through(a, b, c);
    if (!circle) continue;
    const auto inliers = std::count_if(points.begin(), points.end(), [&](const Vector2d& point) {
      return std::abs(Residual(*circle, point)) < tolerance;
    });
    if (inliers <= most) continue;
    most = inliers;
    best = circle;
  }
  return best;
}

std::optional<CircleFit> FitCircle(const std::vector<Vector2d>& points, const Circle& start) {
  if (points.size() < 8) return std::nullopt;
  CircleFit fit;
  fit.circle = start;
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    fit.sigma = RobustSigma(points, fit.circle);
    const CircleNormal normal = NormalOf(points, fit.circle, fit.sigma);
    const Eigen::LDLT<Matrix3d> solver(normal.A);
    if (solver.info() != Eigen::Success || !(normal.A.determinant() > 0)) return std::nullopt;
    const Vector3d step = -solver.solve(normal.b);
    fit.circle.centre += step.head<2>();
    fit.circle.radius += step[2];
    if (!(fit.circle.radius > 0)) return std::nullopt;
    if (step.norm() < 1e-6) break;
  }
  fit.sigma = RobustSigma(points, fit.circle);
  fit.covariance = Spread(points, fit.circle, fit.sigma);
  for (const Vector2d& point : points) {
    fit.inlier.push_back(std::abs(Residual(fit.circle, point)) < 3 * fit.sigma);
  }
  const auto inliers = std::count(fit.inlier.begin(), fit.inlier.end(), true);
  fit.inlier_ratio = static_cast<double>(inliers) / static_cast<double>(points.size());
  return fit;
}

}  // namespace ceilmap::calibration
