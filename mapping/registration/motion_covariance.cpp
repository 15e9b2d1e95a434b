#include "mapping/registration/motion_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ceilmap::registration {
namespace {

// Tukey's biweight w of two-dimensional normal residuals r, cut at 4.685 standard deviations, as
// FitRobust uses it. The fit's variance is E(w^2 r^2) / E(w + r w' / 2)^2 in units of 1 / (J' J);
// from the weighted residuals and weights it is estimated as E(w r^2) E(w^2) / E(w)^3, smaller by
// this factor (integrated numerically).
constexpr double kBiweight = 1.2695;

// Variance of Student's distribution relative to its scale, v / (v - 2), from this many degrees of
// freedom on.
constexpr double kMinFreedom = 4;

// Correlations below this are left out.
constexpr double kNegligible = 1e-3;

using Jacobian24 = Eigen::Matrix<double, 2, 4>;

Jacobian24 ShiftJacobian(const Eigen::Vector2d& p) {
  Jacobian24 j;
  j << 1, 0, -p.y(), p.x(), 0, 1, p.x(), p.y();
  return j;
}

/// Symmetric square root of a positive semidefinite matrix.
Eigen::Matrix2d Root(const Eigen::Matrix2d& m) {
  const double root_det = std::sqrt(std::max(0.0, m.determinant()));
  const double trace = std::sqrt(std::max(0.0, m.trace() + 2 * root_det));
  if (trace <= 0) return Eigen::Matrix2d::Zero();
  return (m + root_det * Eigen::Matrix2d::Identity()) / trace;
}

/// Inverse of the part of the free parameters, zero elsewhere.
Eigen::Matrix4d InverseOfFree(const Eigen::Matrix4d& a, bool scale) {
  const int n = scale ? 4 : 3;
  // Angles move blocks by hundreds of pixels: the equations are scaled, as in FitRobust.
  const Eigen::VectorXd d = a.diagonal().head(n).cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = d.asDiagonal() * a.topLeftCorner(n, n) * d.asDiagonal();
  Eigen::Matrix4d inverse = Eigen::Matrix4d::Zero();
  inverse.topLeftCorner(n, n) =
      d.asDiagonal() * scaled.ldlt().solve(Eigen::MatrixXd::Identity(n, n)) * d.asDiagonal();
  return inverse;
}

/// Sums over the blocks of a fit.
struct FitSums {
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();  ///< sum J' W J
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();      ///< of J' W error, unit variance
  Eigen::Vector4d sampling = Eigen::Vector4d::Zero();     ///< sum J' W (error of interpolation)
  double squares = 0;                                     ///< of the weighted residuals
  double weight = 0;
  double correlated = 0;  ///< sum over pairs of (weight x weight x correlation^2)
};

FitSums SumsOver(const MotionFit& fit,
                 const std::vector<BlockShift>& blocks,
                 const SharedNoise& shared) {
  FitSums sums;
  const Eigen::Vector4d small(
      fit.motion.tx_px, fit.motion.ty_px, fit.motion.theta_rad, std::log(fit.motion.scale));
  std::vector<Jacobian24> rows(blocks.size());  // weight sqrt(W) J
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const BlockShift& block = blocks[i];
    const double weight = fit.weights[i];
    if (weight <= 0) continue;
    const Jacobian24 j = ShiftJacobian(block.point);
    const Eigen::Matrix2d w = block.quality * block.sharpness;
    const Eigen::Vector2d residual = block.shift - j * small;
    rows[i] = weight * Root(w) * j;
    sums.information += weight * j.transpose() * w * j;
    sums.sampling += weight * j.transpose() * w * block.sampling;
    sums.squares += weight * residual.dot(w * residual);
    sums.weight += weight;
    Jacobian24 neighbours = 0.5 * rows[i];
    sums.correlated += weight * weight;
    for (std::size_t k = 0; k < i; ++k) {
      if (fit.weights[k] <= 0) continue;
      const double common = shared.Correlation(block.point - blocks[k].point);
      if (common < kNegligible) continue;
      neighbours += common * rows[k];
      sums.correlated += 2 * weight * fit.weights[k] * common * common;
    }
    const Eigen::Matrix4d product = rows[i].transpose() * neighbours;
    sums.scatter += product + product.transpose();
  }
  return sums;
}

}  // namespace

SharedNoise::SharedNoise(const std::vector<float>& window, double px_per_sample)
    : samples_per_px_(1 / px_per_sample), reach_(static_cast<double>(window.size())) {
  double all = 0;
  const std::vector<double> w(window.begin(), window.end());
  for (const double value : w) all += std::pow(value, 4);
  by_distance_.reserve(w.size() + 1);
  for (std::size_t d = 0; d < w.size(); ++d) {
    double sum = 0;
    for (std::size_t i = d; i < w.size(); ++i) sum += std::pow(w[i] * w[i - d], 2);
    by_distance_.push_back(sum / all);
  }
  by_distance_.push_back(0);
}

double SharedNoise::AlongAxis(double distance_px) const {
  const double at = std::abs(distance_px) * samples_per_px_;
  if (at >= reach_) return 0;
  const auto whole = static_cast<std::size_t>(at);
  const double part = at - static_cast<double>(whole);
  return (1 - part) * by_distance_[whole] + part * by_distance_[whole + 1];
}

double SharedNoise::Correlation(const Eigen::Vector2d& distance_px) const {
  const double along_x = AlongAxis(distance_px.x());
  return along_x > 0 ? along_x * AlongAxis(distance_px.y()) : 0;
}

Eigen::Matrix4d CovarianceOf(const MotionFit& fit,
                             const std::vector<BlockShift>& blocks,
                             const FitParams& params,
                             const SharedNoise& shared) {
  if (!fit.ok) return fit.covariance;
  const FitSums sums = SumsOver(fit, blocks, shared);
  const Eigen::Matrix4d inverse = InverseOfFree(sums.information, params.estimate_scale);
  const double fitted = (inverse * sums.scatter).trace();  // of the residuals' squares
  const double variance = std::max(sums.squares / std::max(1.0, 2 * sums.weight - fitted),
                                   kSigmaFloorPx * kSigmaFloorPx);
  const double freedom = std::max(kMinFreedom,
                                  2 * sums.weight * sums.weight / std::max(sums.correlated, 1e-12) -
                                      (params.estimate_scale ? 4 : 3));
  const Eigen::Vector4d in_common = inverse * sums.sampling;
  return kBiweight * freedom / (freedom - 2) * variance * inverse * sums.scatter * inverse +
         in_common * in_common.transpose();
}

Eigen::Matrix4d AfterMotion(const ImageMotion& first, const Eigen::Matrix4d& covariance) {
  const double c = first.scale * std::cos(first.theta_rad);
  const double s = first.scale * std::sin(first.theta_rad);
  Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
  turn.topLeftCorner<2, 2>() << c, -s, s, c;
  return turn * covariance * turn.transpose();
}

}  // namespace ceilmap::registration
