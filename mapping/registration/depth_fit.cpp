#include "mapping/registration/depth_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "calib/base/statistics.hpp"

namespace ceilmap::registration {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Parameters in the order of the equations (those of a level camera first): their places in the
// covariance.
constexpr std::array<int, 6> kOrder = {0, 1, 3, 2, 4, 5};  // x, y, yaw, height, tilt_x, tilt_y

constexpr int kRounds = 8;
constexpr double kSigmaCeiling = 3;
constexpr double kSigmaFloor = 0.03;  // px; matching errors that blocks have in common
// A block agrees when its residual across the direction of travel is smaller than this, and the one
// along it exceeds this number of standard deviations of what was known of its height by less.
constexpr double kMaxOffPx = 0.8;
constexpr double kMaxSigmas = 3;

/// Residual and derivatives of one block, in pixels of the reference.
struct Linearised {
  Eigen::Vector2d residual;              // measured - predicted
  Eigen::Vector2d along;                 // d predicted / d rho
  Eigen::Matrix<double, 2, 6> jacobian;  // d predicted / d (kOrder)
  Eigen::Matrix2d measured;              // information of the measurement for sigma 1
};

PlaneMotion Moved(const PlaneMotion& m, const Vector6d& step) {
  PlaneMotion moved = m;
  moved.x += step[0];
  moved.y += step[1];
  moved.yaw += step[2];
  moved.height += step[3];
  moved.tilt_x += step[4];
  moved.tilt_y += step[5];
  return moved;
}

Linearised Linearise(const PlaneCamera& camera,
                     const PlaneShift& shift,
                     const PlaneMotion& motion,
                     int parameters) {
  constexpr double kStep = 1e-5;
  const Eigen::Vector2d& x = shift.block.point;
  const Eigen::Matrix2d back = shift.current_from_reference.inverse();
  Linearised l;
  const Eigen::Vector2d predicted = motion.Apply(camera, x, shift.rho);
  l.residual = back * (shift.seen - predicted);
  l.along = back * (motion.Apply(camera, x, shift.rho + kStep) - predicted) / kStep;
  l.jacobian.setZero();
  for (int i = 0; i < parameters; ++i) {
    Vector6d step = Vector6d::Zero();
    step[i] = kStep;
    l.jacobian.col(i) =
        back * (Moved(motion, step).Apply(camera, x, shift.rho) - predicted) / kStep;
  }
  // A measured curvature may be slightly negative along an edge.
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> sharpness;
  sharpness.computeDirect(shift.block.sharpness);
  const Eigen::Vector2d curvature = sharpness.eigenvalues().cwiseMax(1e-3);
  l.measured = shift.block.quality * sharpness.eigenvectors() * curvature.asDiagonal() *
               sharpness.eigenvectors().transpose();
  return l;
}

/// Information of the residual with the height integrated out.
Eigen::Matrix2d Information(const Linearised& l, double rho_sigma, double sigma_px) {
  // (C + s^2 g g')^-1 = M - M g g' M / (1 / s^2 + g' M g),  M = C^-1
  Eigen::Matrix2d m = l.measured / (sigma_px * sigma_px);
  if (rho_sigma <= 0) return m;
  const Eigen::Vector2d mg = m * l.along;
  return m - mg * mg.transpose() / (1 / (rho_sigma * rho_sigma) + l.along.dot(mg));
}

/// Weight of a residual: first Cauchy's, which reaches far errors of the start; then Tukey's
/// biweight, because a nearer thing at the edge of a block pulls only one way.
double RobustWeight(double chi2, int round) {
  constexpr int kCauchyRounds = 3;
  constexpr double kCauchy = 2.4;  // standard deviations
  constexpr double kTukey = 4;
  if (round < kCauchyRounds) return 1 / (1 + chi2 / (kCauchy * kCauchy));
  const double inside = std::max(0.0, 1 - chi2 / (kTukey * kTukey));
  return inside * inside;
}

/// What one block says of its height and whether it agrees, at the final motion.
BlockHeight Judge(const Linearised& l, const PlaneShift& shift, double sigma_px) {
  BlockHeight out;
  const Eigen::Matrix2d m = l.measured / (sigma_px * sigma_px);
  const double info = l.along.dot(m * l.along);
  const double prior = shift.rho_sigma > 0 ? 1 / (shift.rho_sigma * shift.rho_sigma) : 1e12;
  const double pull = l.along.dot(m * l.residual);
  out.sigma = 1 / std::sqrt(info + prior);
  out.rho = shift.rho + pull / (info + prior);
  // The residual that no height explains, in pixels of full texture; and how far the height is from
  // what was known.
  const double weight = sigma_px * sigma_px / std::max(1e-9, shift.block.quality);
  const double across2 =
      weight * (l.residual.dot(m * l.residual) - (info > 1e-12 ? pull * pull / info : 0));
  const double off_rho = info > 1e-12 ? std::abs(pull / info) : 0;
  const double slack = kMaxOffPx / std::max(l.along.norm(), 1e-9);
  out.inlier = across2 < kMaxOffPx * kMaxOffPx && off_rho < kMaxSigmas * shift.rho_sigma + slack;
  const Eigen::Matrix2d w = Information(l, shift.rho_sigma, sigma_px);
  out.evidence =
      std::clamp(sigma_px * sigma_px * w.trace() / std::max(1e-9, shift.block.quality), 0.0, 1.0);
  return out;
}

}  // namespace

DepthFit FitDepthMotion(const PlaneCamera& camera,
                        const std::vector<PlaneShift>& shifts,
                        const PlaneMotion& start,
                        const DepthFitParams& params) {
  DepthFit fit;
  fit.motion = start;
  constexpr std::size_t kFewest = 6;
  if (shifts.size() < kFewest) return fit;
  const int n = params.fit_tilt ? 6 : 3;
  double sigma = params.start_sigma_px;
  std::vector<double> sizes;
  std::vector<Linearised> rows(shifts.size());
  Eigen::MatrixXd inverse;
  for (int round = 0; round < kRounds; ++round) {
    Matrix6d a = Matrix6d::Zero();
    Vector6d b = Vector6d::Zero();
    sizes.clear();
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      rows[i] = Linearise(camera, shifts[i], fit.motion, n);
      const Linearised& l = rows[i];
      const Eigen::Matrix2d w = Information(l, shifts[i].rho_sigma, sigma);
      const double chi2 = l.residual.dot(w * l.residual);
      const double weight = RobustWeight(chi2, round);
      a += weight * l.jacobian.transpose() * w * l.jacobian;
      b += weight * l.jacobian.transpose() * w * l.residual;
      // Degrees of freedom that the height leaves: 1 where it is unknown, 2 where it is known.
      const double degrees =
          std::clamp((w * l.measured.inverse()).trace() * sigma * sigma, 1.0, 2.0);
      const double median_chi2 = 0.455 + 0.931 * (degrees - 1);
      sizes.push_back(chi2 / median_chi2);
    }
    const double ratio = std::sqrt(Median(sizes));
    sigma = std::clamp(sigma * std::clamp(ratio, 0.3, 2.0), kSigmaFloor, kSigmaCeiling);
    if (!params.fit_motion) continue;
    const Eigen::MatrixXd used = a.topLeftCorner(n, n);
    const Eigen::VectorXd d = used.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(d.asDiagonal() * used * d.asDiagonal());
    if (ldlt.info() != Eigen::Success || ldlt.vectorD().minCoeff() < 1e-9) return fit;
    Vector6d step = Vector6d::Zero();
    step.head(n) = d.asDiagonal() * ldlt.solve(d.asDiagonal() * b.head(n));
    fit.motion = Moved(fit.motion, step);
    inverse = d.asDiagonal() * ldlt.solve(Eigen::MatrixXd::Identity(n, n)) * d.asDiagonal();
  }
  fit.sigma_px = sigma;
  for (int i = 0; params.fit_motion && i < n; ++i) {
    for (int j = 0; j < n; ++j)
      fit.covariance(kOrder[static_cast<std::size_t>(i)], kOrder[static_cast<std::size_t>(j)]) =
          inverse(i, j);
  }
  fit.blocks.reserve(shifts.size());
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const Linearised l = Linearise(camera, shifts[i], fit.motion, 0);
    const BlockHeight height = Judge(l, shifts[i], sigma);
    fit.blocks.push_back(height);
    fit.content += shifts[i].block.content;
    if (!height.inlier) continue;
    fit.inlier_content += shifts[i].block.content;
    ++fit.inliers;
    fit.support += shifts[i].block.peak * height.evidence;
  }
  fit.ok = fit.covariance.allFinite();
  return fit;
}

}  // namespace ceilmap::registration
