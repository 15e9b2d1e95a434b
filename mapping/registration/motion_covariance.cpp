#include "mapping/registration/motion_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace ceilmap::registration {
namespace {

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

/// Inverse of the part of the fitted parameters, zero elsewhere. @param fitted  Their number.
template <int N>
Eigen::Matrix<double, N, N> InverseOfFitted(Eigen::Matrix<double, N, N> a, int& fitted) {
  std::array<bool, N> fixed{};
  fitted = N;
  for (int i = 0; i < N; ++i) {
    if (a(i, i) > 0) continue;
    fixed.at(static_cast<std::size_t>(i)) = true;
    a(i, i) = 1;
    --fitted;
  }
  // Angles move blocks by hundreds of pixels: the equations are scaled, as in FitRobust.
  const Eigen::Matrix<double, N, 1> d = a.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix<double, N, N> scaled = d.asDiagonal() * a * d.asDiagonal();
  Eigen::Matrix<double, N, N> inverse =
      d.asDiagonal() * scaled.ldlt().solve(Eigen::Matrix<double, N, N>::Identity()) *
      d.asDiagonal();
  for (int i = 0; i < N; ++i) {
    if (fixed.at(static_cast<std::size_t>(i))) inverse(i, i) = 0;
  }
  return inverse;
}

/// Sums over the blocks of a fit. M is (I + unknown unknown')^-1.
template <int N>
struct FitSums {
  using Matrix = Eigen::Matrix<double, N, N>;
  Matrix information = Matrix::Zero();  ///< sum J' w M J
  Matrix noise = Matrix::Zero();        ///< scatter of J' w M noise, for a unit variance
  Matrix own = Matrix::Zero();          ///< the same of what is unknown of each block
  Eigen::Matrix<double, N, 1> sampling = Eigen::Matrix<double, N, 1>::Zero();
  double squares = 0;     ///< of M residual, times the weights: mostly free of what is unknown
  double weight = 0;      ///< weights x degrees of freedom
  double correlated = 0;  ///< the same, sum over pairs of products x correlation^2
};

/// The part of a block in the sums.
template <int N>
struct BlockRow {
  Eigen::Vector2d point;
  Eigen::Matrix<double, 2, N> moved;  ///< w M J: by a unit of noise
  double weight;
};

template <int N>
FitSums<N> SumsOver(const std::vector<FittedBlock<N>>& blocks, const SharedNoise& shared) {
  FitSums<N> sums;
  std::vector<BlockRow<N>> rows;
  rows.reserve(blocks.size());
  for (const FittedBlock<N>& block : blocks) {
    const double w = block.weight;
    if (w <= 0) continue;
    const Eigen::Vector2d& u = block.unknown;
    const Eigen::Matrix2d m =
        Eigen::Matrix2d::Identity() - u * u.transpose() / (1 + u.squaredNorm());
    const BlockRow<N> row{block.point, w * m * block.jacobian, w * m.trace()};
    sums.information += block.jacobian.transpose() * row.moved;
    sums.sampling += row.moved.transpose() * block.sampling;
    sums.squares += w * (m * block.residual).squaredNorm();
    sums.weight += row.weight;
    sums.correlated += row.weight * row.weight;
    const Eigen::Matrix<double, N, 1> own = row.moved.transpose() * u;
    Eigen::Matrix<double, 2, N> neighbours = 0.5 * row.moved;
    for (const BlockRow<N>& other : rows) {
      const double common = shared.Correlation(block.point - other.point);
      if (common < kNegligible) continue;
      neighbours += common * other.moved;
      sums.correlated += 2 * row.weight * other.weight * common * common;
    }
    const typename FitSums<N>::Matrix product = row.moved.transpose() * neighbours;
    sums.noise += product + product.transpose();
    sums.own += own * own.transpose();
    rows.push_back(row);
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

Eigen::Matrix2d RootOf(const Eigen::Matrix2d& m) {
  const double root_det = std::sqrt(std::max(0.0, m.determinant()));
  const double trace = std::sqrt(std::max(0.0, m.trace() + 2 * root_det));
  if (trace <= 0) return Eigen::Matrix2d::Zero();
  return (m + root_det * Eigen::Matrix2d::Identity()) / trace;
}

template <int N>
Eigen::Matrix<double, N, N> CovarianceOf(const std::vector<FittedBlock<N>>& blocks,
                                         const SharedNoise& shared,
                                         double loss,
                                         double min_variance) {
  using Matrix = Eigen::Matrix<double, N, N>;
  const FitSums<N> sums = SumsOver(blocks, shared);
  int parameters = 0;
  const Matrix inverse = InverseOfFitted<N>(sums.information, parameters);
  const double fitted = (inverse * sums.noise).trace();  // of the residuals' squares
  const double variance =
      std::max(sums.squares / std::max(1.0, sums.weight - fitted), min_variance);
  const double freedom = std::max(
      kMinFreedom, sums.weight * sums.weight / std::max(0.5 * sums.correlated, 1e-12) - parameters);
  const Eigen::Matrix<double, N, 1> in_common = inverse * sums.sampling;
  const Matrix scatter = loss * freedom / (freedom - 2) * variance * sums.noise + sums.own;
  return inverse * scatter * inverse + in_common * in_common.transpose();
}

template Eigen::Matrix<double, 3, 3> CovarianceOf(const std::vector<FittedBlock<3>>&,
                                                  const SharedNoise&,
                                                  double,
                                                  double);
template Eigen::Matrix<double, 4, 4> CovarianceOf(const std::vector<FittedBlock<4>>&,
                                                  const SharedNoise&,
                                                  double,
                                                  double);
template Eigen::Matrix<double, 6, 6> CovarianceOf(const std::vector<FittedBlock<6>>&,
                                                  const SharedNoise&,
                                                  double,
                                                  double);

Eigen::Matrix4d CovarianceOf(const MotionFit& fit,
                             const std::vector<BlockShift>& blocks,
                             const FitParams& params,
                             const SharedNoise& shared) {
  if (!fit.ok) return fit.covariance;
  const Eigen::Vector4d small(
      fit.motion.tx_px, fit.motion.ty_px, fit.motion.theta_rad, std::log(fit.motion.scale));
  std::vector<FittedBlock<4>> fitted;
  fitted.reserve(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (fit.weights[i] <= 0) continue;
    const BlockShift& block = blocks[i];
    const Jacobian24 j = ShiftJacobian(block.point);
    const Eigen::Matrix2d root = RootOf(block.quality * block.sharpness);
    FittedBlock<4> one;
    one.point = block.point;
    one.jacobian = root * j;
    if (!params.estimate_scale) one.jacobian.col(3).setZero();
    one.residual = root * (block.shift - j * small);
    one.sampling = root * block.sampling;
    one.weight = fit.weights[i];
    fitted.push_back(one);
  }
  return CovarianceOf(fitted, shared, kBiweightLoss, kSigmaFloorPx * kSigmaFloorPx);
}

Eigen::Matrix4d AfterMotion(const ImageMotion& first, const Eigen::Matrix4d& covariance) {
  const double c = first.scale * std::cos(first.theta_rad);
  const double s = first.scale * std::sin(first.theta_rad);
  Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
  turn.topLeftCorner<2, 2>() << c, -s, s, c;
  return turn * covariance * turn.transpose();
}

}  // namespace ceilmap::registration
