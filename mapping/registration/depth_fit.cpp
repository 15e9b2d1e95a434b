#include "mapping/registration/depth_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "calib/base/statistics.hpp"
#include "mapping/registration/plane_projection.hpp"

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

/// What of a block does not depend on the motion.
struct FixedPart {
  FixedPart(const PlaneCamera& camera, const PlaneShift& shift)
      : ray(PlaneProjection<double>::RayOf(camera, shift.block.point)),
        reference_from_current(shift.current_from_reference.inverse()) {
    // A measured curvature may be slightly negative along an edge.
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> sharpness;
    sharpness.computeDirect(shift.block.sharpness);
    const Eigen::Vector2d curvature = sharpness.eigenvalues().cwiseMax(1e-3);
    measured = shift.block.quality * sharpness.eigenvectors() * curvature.asDiagonal() *
               sharpness.eigenvectors().transpose();
    covariance = measured.inverse();
  }

  Eigen::Vector2d ray;  // in the reference
  Eigen::Matrix2d reference_from_current;
  Eigen::Matrix2d measured;    // information of the measurement for sigma 1
  Eigen::Matrix2d covariance;  // its inverse
};

/// Residual of one block, in pixels of the reference, and its derivative by the height.
struct Residual {
  Eigen::Vector2d residual;  // measured - predicted
  Eigen::Vector2d along;     // d predicted / d rho
};

/// With the derivatives by the first N parameters.
template <int N>
struct Linearised : Residual {
  Eigen::Matrix<double, 2, N> jacobian;  // d predicted / d (kOrder)
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

/// Derivatives by differences: a motion, and N motions of which one parameter each is larger.
template <int N>
class Lineariser {
 public:
  Lineariser(const PlaneCamera& camera, const PlaneMotion& motion)
      : at_(ProjectionOf(camera, motion)) {
    moved_.reserve(N);
    for (int i = 0; i < N; ++i) {
      Vector6d step = Vector6d::Zero();
      step[i] = kStep;
      moved_.push_back(ProjectionOf(camera, Moved(motion, step)));
    }
  }

  [[nodiscard]] Linearised<N> At(const PlaneShift& shift, const FixedPart& fixed) const {
    const Eigen::Vector2d& ray = fixed.ray;
    const Eigen::Matrix2d& back = fixed.reference_from_current;
    Linearised<N> l;
    const Eigen::Vector2d predicted = at_.ApplyToRay(ray, shift.rho);
    l.residual = back * (shift.seen - predicted);
    l.along = back * (at_.ApplyToRay(ray, shift.rho + kStep) - predicted) / kStep;
    if constexpr (N > 0) {
      for (int i = 0; i < N; ++i) {
        const auto k = static_cast<std::size_t>(i);
        l.jacobian.col(i) = back * (moved_[k].ApplyToRay(ray, shift.rho) - predicted) / kStep;
      }
    }
    return l;
  }

 private:
  static constexpr double kStep = 1e-5;
  PlaneProjection<double> at_;
  std::vector<PlaneProjection<double>> moved_;
};

/// Information of the residual with the height integrated out.
Eigen::Matrix2d Information(const Residual& l,
                            const Eigen::Matrix2d& measured,
                            double rho_sigma,
                            double sigma_px) {
  // (C + s^2 g g')^-1 = M - M g g' M / (1 / s^2 + g' M g),  M = C^-1
  Eigen::Matrix2d m = measured / (sigma_px * sigma_px);
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
BlockHeight Judge(const Residual& l,
                  const FixedPart& fixed,
                  const PlaneShift& shift,
                  double sigma_px) {
  BlockHeight out;
  const Eigen::Matrix2d m = fixed.measured / (sigma_px * sigma_px);
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
  const Eigen::Matrix2d w = Information(l, fixed.measured, shift.rho_sigma, sigma_px);
  out.evidence =
      std::clamp(sigma_px * sigma_px * w.trace() / std::max(1e-9, shift.block.quality), 0.0, 1.0);
  return out;
}

/// A residual for a standard deviation of a fully informative block.
struct Weighed {
  Weighed(const Residual& l, const FixedPart& fixed, double rho_sigma, double sigma)
      : information(Information(l, fixed.measured, rho_sigma, sigma)),
        chi2(l.residual.dot(information * l.residual)) {
    // Degrees of freedom that the height leaves: 1 where it is unknown, 2 where it is known.
    const double degrees =
        std::clamp((information * fixed.covariance).trace() * sigma * sigma, 1.0, 2.0);
    const double median_chi2 = 0.455 + 0.931 * (degrees - 1);
    size = chi2 / median_chi2;
  }

  Eigen::Matrix2d information;
  double chi2;
  double size;  // chi2 in units of its median
};

/// The standard deviation that the residuals show, changed by no more than a factor.
double NextSigma(double sigma, const std::vector<double>& sizes) {
  const double ratio = std::sqrt(Median(sizes));
  return std::clamp(sigma * std::clamp(ratio, 0.3, 2.0), kSigmaFloor, kSigmaCeiling);
}

/// Sets sigma_px of a fit whose motion is known.
void FitSigma(const PlaneCamera& camera,
              const std::vector<PlaneShift>& shifts,
              const std::vector<FixedPart>& fixed,
              const DepthFitParams& params,
              DepthFit& fit) {
  const Lineariser<0> lineariser(camera, fit.motion);
  std::vector<Residual> rows;
  rows.reserve(shifts.size());
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    rows.push_back(lineariser.At(shifts[i], fixed[i]));
  }
  double sigma = params.start_sigma_px;
  std::vector<double> sizes(shifts.size());
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      sizes[i] = Weighed(rows[i], fixed[i], shifts[i].rho_sigma, sigma).size;
    }
    sigma = NextSigma(sigma, sizes);
  }
  fit.sigma_px = sigma;
}

/// The blocks of a fit for CovarianceOf. @tparam N  Parameters, of kOrder.
template <int N>
std::vector<FittedBlock<N>> FittedBlocks(const Lineariser<N>& at,
                                         const std::vector<PlaneShift>& shifts,
                                         const std::vector<FixedPart>& fixed,
                                         double sigma) {
  std::vector<FittedBlock<N>> blocks;
  blocks.reserve(shifts.size());
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const Linearised<N> l = at.At(shifts[i], fixed[i]);
    const double chi2 = Weighed(l, fixed[i], shifts[i].rho_sigma, sigma).chi2;
    const double weight = RobustWeight(chi2, kRounds);
    if (weight <= 0) continue;
    const Eigen::Matrix2d root = RootOf(fixed[i].measured) / sigma;
    FittedBlock<N> one;
    one.point = shifts[i].block.point;
    one.jacobian = root * l.jacobian;
    one.residual = root * l.residual;
    one.sampling = root * shifts[i].block.sampling;
    one.unknown = shifts[i].rho_sigma * root * l.along;
    one.weight = weight;
    blocks.push_back(one);
  }
  return blocks;
}

/// The factor of CovarianceOf for the weights of a fit. Where heights explain residuals, or the
/// scale is at its lower limit, the weights are nearer to 1 than those of normal residuals.
template <int N>
double LossOf(const std::vector<FittedBlock<N>>& blocks) {
  constexpr double kNormalWeight = 0.78;  // mean of normal residuals
  double sum = 0;
  for (const FittedBlock<N>& block : blocks) sum += block.weight;
  const double mean = blocks.empty() ? 1 : sum / static_cast<double>(blocks.size());
  const double part = std::clamp((1 - mean) / (1 - kNormalWeight), 0.0, 1.0);
  return 1 + part * (kNearBiweightLoss - 1);
}

/// Of N parameters in their places.
template <int N>
Matrix6d InPlaces(const Eigen::Matrix<double, N, N>& covariance) {
  Matrix6d full = Matrix6d::Zero();
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j)
      full(kOrder[static_cast<std::size_t>(i)], kOrder[static_cast<std::size_t>(j)]) =
          covariance(i, j);
  }
  return full;
}

/// What a fit is made from.
struct FitInput {
  const PlaneCamera& camera;
  const std::vector<PlaneShift>& shifts;
  const std::vector<FixedPart>& fixed;
  const DepthFitParams& params;
  const SharedNoise* shared;
};

/// Sets motion, covariances and sigma_px of the fit. @tparam N  Parameters, of kOrder.
/// @return false where the blocks do not determine them.
template <int N>
bool FitRounds(const FitInput& input, DepthFit& fit) {
  const auto& [camera, shifts, fixed, params, shared] = input;
  double sigma = params.start_sigma_px;
  std::vector<double> sizes(shifts.size());
  Eigen::MatrixXd inverse;
  for (int round = 0; round < kRounds; ++round) {
    const Lineariser<N> lineariser(camera, fit.motion);
    Eigen::Matrix<double, N, N> a = Eigen::Matrix<double, N, N>::Zero();
    Eigen::Matrix<double, N, 1> b = Eigen::Matrix<double, N, 1>::Zero();
    for (std::size_t i = 0; i < shifts.size(); ++i) {
      const Linearised<N> l = lineariser.At(shifts[i], fixed[i]);
      const Weighed weighed(l, fixed[i], shifts[i].rho_sigma, sigma);
      const double weight = RobustWeight(weighed.chi2, round);
      a += weight * l.jacobian.transpose() * weighed.information * l.jacobian;
      b += weight * l.jacobian.transpose() * weighed.information * l.residual;
      sizes[i] = weighed.size;
    }
    sigma = NextSigma(sigma, sizes);
    const Eigen::MatrixXd used = a;
    const Eigen::VectorXd d = used.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(d.asDiagonal() * used * d.asDiagonal());
    if (ldlt.info() != Eigen::Success || ldlt.vectorD().minCoeff() < 1e-9) return false;
    Vector6d step = Vector6d::Zero();
    step.head(N) = d.asDiagonal() * ldlt.solve(d.asDiagonal() * b);
    fit.motion = Moved(fit.motion, step);
    inverse = d.asDiagonal() * ldlt.solve(Eigen::MatrixXd::Identity(N, N)) * d.asDiagonal();
  }
  fit.sigma_px = sigma;
  fit.spread = InPlaces<N>(inverse);
  fit.covariance = fit.spread;
  if (shared == nullptr) return true;
  const auto blocks = FittedBlocks<N>({camera, fit.motion}, shifts, fixed, sigma);
  fit.covariance = InPlaces<N>(CovarianceOf(
      blocks, *shared, LossOf(blocks), kSigmaFloorPx * kSigmaFloorPx / (sigma * sigma)));
  return true;
}

/// As FitRounds, by what is to be fitted.
bool FitMotionOrSigma(const FitInput& input, DepthFit& fit) {
  if (!input.params.fit_motion) {
    FitSigma(input.camera, input.shifts, input.fixed, input.params, fit);
    return true;
  }
  return input.params.fit_tilt ? FitRounds<6>(input, fit) : FitRounds<3>(input, fit);
}

}  // namespace

DepthFit FitDepthMotion(const PlaneCamera& camera,
                        const std::vector<PlaneShift>& shifts,
                        const PlaneMotion& start,
                        const DepthFitParams& params,
                        const SharedNoise* shared) {
  DepthFit fit;
  fit.motion = start;
  constexpr std::size_t kFewest = 6;
  if (shifts.size() < kFewest) return fit;
  std::vector<FixedPart> fixed;
  fixed.reserve(shifts.size());
  for (const PlaneShift& shift : shifts) fixed.emplace_back(camera, shift);
  if (!FitMotionOrSigma({camera, shifts, fixed, params, shared}, fit)) return fit;
  fit.blocks.reserve(shifts.size());
  const Lineariser<0> at(camera, fit.motion);
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const BlockHeight height = Judge(at.At(shifts[i], fixed[i]), fixed[i], shifts[i], fit.sigma_px);
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
