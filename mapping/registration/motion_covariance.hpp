#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/registration/motion_fit.hpp"

namespace ceilmap::registration {

/// Correlation of the errors of two equal blocks that overlap. An error is a sum over the noise of
/// the block's pixels, weighted by the window of each image and by the content, which both blocks
/// share: corr(d) = g(d_x) g(d_y) with g(d) = sum w^2(x) w^2(x - d) / sum w^4(x).
class SharedNoise {
 public:
  /// Of blocks that have nothing in common.
  SharedNoise() = default;

  /// @param window  of a block along one axis. @param px_per_sample  Pixels of the blocks' centres
  /// for one of the window.
  explicit SharedNoise(const std::vector<float>& window, double px_per_sample = 1);

  /// 0..1. @param distance_px  of the blocks' centres.
  [[nodiscard]] double Correlation(const Eigen::Vector2d& distance_px) const;

 private:
  [[nodiscard]] double AlongAxis(double distance_px) const;

  double samples_per_px_ = 1;
  double reach_ = 0;  // samples, from which on blocks share nothing
  std::vector<double> by_distance_;
};

/// One block of a fit of N parameters, at what was fitted, in units of the standard deviation that
/// the fit takes its measurement to have.
template <int N>
struct FittedBlock {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();  ///< centre in the reference, pixels
  /// Of the residual by the parameters. Parameters that are not fitted have columns of zeros.
  Eigen::Matrix<double, 2, N> jacobian = Eigen::Matrix<double, 2, N>::Zero();
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();
  Eigen::Vector2d sampling = Eigen::Vector2d::Zero();  ///< BlockShift::sampling
  /// Change of the residual by one standard deviation of what is not known of the block alone (its
  /// height). The fit weighs a residual r by (I + unknown unknown')^-1.
  Eigen::Vector2d unknown = Eigen::Vector2d::Zero();
  double weight = 1;  ///< robust weight, 0..1
};

/// From the residuals and weights of a robust fit, the variance of two-dimensional normal errors is
/// estimated as E(w r^2) E(w^2) / E(w)^3. That of the fit is E(w^2 r^2) / E(w + r w' / 2)^2: larger
/// by these factors (integrated numerically).
inline constexpr double kBiweightLoss = 1.2695;      ///< cut at 4.685 standard deviations
inline constexpr double kNearBiweightLoss = 1.4253;  ///< cut at 4
inline constexpr double kCauchyLoss = 1.2611;        ///< of scale 2.3849

/// Symmetric square root of a positive semidefinite matrix.
Eigen::Matrix2d RootOf(const Eigen::Matrix2d& m);

/// Covariance of robust least squares, from the residuals:
///  - neighbouring blocks have noise in common, so that n blocks are fewer independent ones; their
///    residuals are smaller than their errors, too;
///  - what is not known of a block alone is its own;
///  - robust weights lower the residuals more than the errors;
///  - few residuals leave their variance uncertain: the covariance is that of Student's
///    distribution;
///  - all blocks may have the same error of interpolation (BlockShift::sampling), which no residual
///    shows.
/// Rows and columns of parameters that are not fitted are zero. N is 3, 4 or 6.
/// @param loss  One of the factors above. @param min_variance  Lower limit of the variance of a
/// residual, in units of that which the fit takes it to have.
template <int N>
Eigen::Matrix<double, N, N> CovarianceOf(const std::vector<FittedBlock<N>>& blocks,
                                         const SharedNoise& shared,
                                         double loss,
                                         double min_variance);

/// The same of a fit by FitRobust, of (tx, ty, theta, ln scale).
/// @return MotionFit::covariance where the fit is not ok.
Eigen::Matrix4d CovarianceOf(const MotionFit& fit,
                             const std::vector<BlockShift>& blocks,
                             const FitParams& params,
                             const SharedNoise& shared);

/// Covariance of `first` after a small motion with this covariance was put before it
/// (Compose(first, small)): shifts of the reference become shifts of the current image.
Eigen::Matrix4d AfterMotion(const ImageMotion& first, const Eigen::Matrix4d& covariance);

}  // namespace ceilmap::registration
