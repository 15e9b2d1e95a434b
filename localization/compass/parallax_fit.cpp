#include "localization/compass/parallax_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "calib/base/pose2.hpp"

namespace ceilmap::compass {
namespace {

// The nearness of the surroundings around the circle is a Fourier series of this order ...
constexpr int kOrder = 5;
// ... in which the expected magnitude of the terms of order k is this ratio / k of the mean.
constexpr double kRoughness = 0.5;
// Standard deviation of a sector's shift beyond its own noise, rad, > 0: a constant, and a ratio
// of the shift that travel causes there (objects at several distances in one direction). Ahead and
// behind there is none, so that these directions count most.
constexpr double kShiftFloorRad = 0.0014;
constexpr double kFloorRatio = 0.055;
// Residuals beyond this number of standard deviations lose weight progressively, > 0.
constexpr double kRobustSigmas = 1.4;
// Standard deviation of the expected direction of travel, rad, > 0.
constexpr double kDirectionSigmaRad = 0.105;

using std::numbers::pi;

constexpr int kMaxOrder = 12;
// Order of the unknowns: rotation, direction, then the series (mean, cosine and sine of each
// order).
constexpr int kRotation = 0;
constexpr int kDirection = 1;
constexpr int kSeries = 2;
constexpr int kMaxUnknowns = kSeries + 1 + 2 * kMaxOrder;

using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnknowns, 1>;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;

/// Terms of the series at a sector's azimuth: 1, then cosine and sine of each order.
Vector Series(double azimuth_rad, int order) {
  Vector terms(1 + 2 * order);
  terms[0] = 1;
  for (int k = 1; k <= order; ++k) {
    terms[2 * k - 1] = std::cos(k * azimuth_rad);
    terms[2 * k] = std::sin(k * azimuth_rad);
  }
  return terms;
}

/// The shift of one sector that follows from the unknowns, and its derivatives with respect to
/// them.
double Model(double azimuth_rad, const Vector& terms, const Vector& x, Vector& derivatives) {
  const double sine = std::sin(azimuth_rad - x[kDirection]);
  const double nearness = terms.dot(x.tail(terms.size()));
  derivatives[kRotation] = 1;
  derivatives[kDirection] = -nearness * std::cos(azimuth_rad - x[kDirection]);
  derivatives.tail(terms.size()) = sine * terms;
  return x[kRotation] + nearness * sine;
}

/// Of a sector's shift beyond its own noise.
double FloorVariance(double azimuth_rad, const Vector& x) {
  const double travelled = x[kSeries] * std::sin(azimuth_rad - x[kDirection]);
  const double sigma = kShiftFloorRad + kFloorRatio * std::abs(travelled);
  return sigma * sigma;
}

double MedianShift(std::span<const SectorShift> shifts) {
  std::vector<double> values;
  values.reserve(shifts.size());
  for (const SectorShift& shift : shifts) values.push_back(shift.shift_rad);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Information of the prior for each unknown.
Vector Prior(double direction_sigma_rad, double mean_nearness_rad) {
  constexpr double kAnyNearness = 0.35;
  constexpr double kMinNearness = 0.0035;
  Vector information = Vector::Zero(kSeries + 1 + 2 * kOrder);
  information[kDirection] = 1 / (direction_sigma_rad * direction_sigma_rad);
  information[kSeries] = 1 / (kAnyNearness * kAnyNearness);
  const double nearness = std::max(std::abs(mean_nearness_rad), kMinNearness);
  for (int k = 1; k <= kOrder; ++k) {
    const double sigma = kRoughness / k * nearness;
    information[kSeries + 2 * k - 1] = information[kSeries + 2 * k] = 1 / (sigma * sigma);
  }
  return information;
}

/// @param direction_sigma_rad  Standard deviation of the expected direction.
ParallaxFit Fit(std::span<const SectorShift> shifts,
                int sectors_asked,
                double expected_direction_rad,
                double direction_sigma_rad) {
  ParallaxFit fit;
  fit.variance_rad2 = std::numeric_limits<double>::infinity();
  constexpr std::size_t kMinSectors = 6;
  if (shifts.size() < kMinSectors) return fit;
  const Eigen::Index unknowns = kSeries + 1 + 2 * kOrder;
  Vector expected = Vector::Zero(unknowns);
  expected[kDirection] = expected_direction_rad;
  Vector x = expected;
  x[kRotation] = MedianShift(shifts);
  Vector derivatives(unknowns);
  Matrix information(unknowns, unknowns);
  Eigen::LLT<Matrix> solver;
  std::vector<Vector> terms;
  terms.reserve(shifts.size());
  for (const SectorShift& shift : shifts) terms.push_back(Series(shift.azimuth_rad, kOrder));
  double inliers = 0;
  double cost = 0;
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds; ++round) {
    const Vector prior = Prior(direction_sigma_rad, x[kSeries]);
    information = prior.asDiagonal();
    Vector gradient = prior.cwiseProduct(expected - x);
    inliers = 0;
    cost = (x - expected).cwiseAbs2().dot(prior);
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      const SectorShift& shift = shifts[i];
      const double residual = shift.shift_rad - Model(shift.azimuth_rad, terms[i], x, derivatives);
      const double variance = shift.variance_rad2 + FloorVariance(shift.azimuth_rad, x);
      const double off2 = residual * residual / variance;
      const double robust = kRobustSigmas * kRobustSigmas;
      const double trust = 1 / (1 + off2 / robust);
      cost += robust * std::log1p(off2 / robust);
      // Residuals beyond three standard deviations are caused by another motion, not by noise.
      inliers += off2 < 9 ? 1 : 0;
      information += trust / variance * derivatives * derivatives.transpose();
      gradient += trust / variance * residual * derivatives;
    }
    solver.compute(information);
    x += solver.solve(gradient);
    // A larger deviation of the direction is noise of a robot that hardly moved.
    x[kDirection] =
        std::clamp(x[kDirection], expected_direction_rad - pi / 4, expected_direction_rad + pi / 4);
  }
  fit.rotation_rad = x[kRotation];
  fit.variance_rad2 = solver.solve(Vector::Unit(unknowns, kRotation))[kRotation];
  fit.direction_rad = WrapAngle(x[kDirection]);
  fit.parallax_rad = x[kSeries];
  fit.inlier_ratio = inliers / sectors_asked;
  fit.cost = cost;
  return fit;
}

}  // namespace

ParallaxFit FitParallax(std::span<const SectorShift> shifts,
                        int sectors_asked,
                        double expected_direction_rad) {
  return Fit(shifts, sectors_asked, expected_direction_rad, kDirectionSigmaRad);
}

ParallaxFit FitParallaxOfAnyDirection(std::span<const SectorShift> shifts, int sectors_asked) {
  // Each direction of travel also stands for its opposite, so these four cover the circle.
  constexpr std::size_t kDirections = 4;
  constexpr double kWideSigmaRad = pi / (2 * kDirections);
  std::array<ParallaxFit, kDirections> fits;
  for (std::size_t i = 0; i < kDirections; ++i) {
    fits[i] = Fit(shifts, sectors_asked, pi * static_cast<double>(i) / kDirections, kWideSigmaRad);
  }
  ParallaxFit best = *std::min_element(
      fits.begin(), fits.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  if (best.inlier_ratio <= 0) return best;
  double total = 0;
  double mean = 0;
  for (const ParallaxFit& fit : fits) {
    const double likelihood = std::exp(-0.5 * (fit.cost - best.cost));
    total += likelihood;
    mean += likelihood * fit.rotation_rad;
  }
  mean /= total;
  double variance = 0;
  for (const ParallaxFit& fit : fits) {
    const double off = fit.rotation_rad - mean;
    variance += std::exp(-0.5 * (fit.cost - best.cost)) / total * (fit.variance_rad2 + off * off);
  }
  best.rotation_rad = mean;
  best.variance_rad2 = variance;
  return best;
}

}  // namespace ceilmap::compass
