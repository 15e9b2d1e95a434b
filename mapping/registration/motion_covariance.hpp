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
  /// @param window  of a block along one axis. @param px_per_sample  Pixels of the blocks' centres
  /// for one of the window.
  explicit SharedNoise(const std::vector<float>& window, double px_per_sample = 1);

  /// 0..1. @param distance_px  of the blocks' centres.
  [[nodiscard]] double Correlation(const Eigen::Vector2d& distance_px) const;

 private:
  [[nodiscard]] double AlongAxis(double distance_px) const;

  double samples_per_px_;
  double reach_;  // samples, from which on blocks share nothing
  std::vector<double> by_distance_;
};

/// Covariance of a fit by FitRobust, of (tx, ty, theta, ln scale), from its residuals:
///  - neighbouring blocks have noise in common, so that n blocks are fewer independent ones; their
///    residuals are smaller than their errors, too;
///  - Tukey's weights lower the residuals more than the errors;
///  - few residuals leave their variance uncertain: the covariance is that of Student's
///    distribution;
///  - all blocks may have the same error of interpolation (BlockShift::sampling), which no residual
///    shows.
/// @return MotionFit::covariance where the fit is not ok.
Eigen::Matrix4d CovarianceOf(const MotionFit& fit,
                             const std::vector<BlockShift>& blocks,
                             const FitParams& params,
                             const SharedNoise& shared);

/// Covariance of `first` after a small motion with this covariance was put before it
/// (Compose(first, small)): shifts of the reference become shifts of the current image.
Eigen::Matrix4d AfterMotion(const ImageMotion& first, const Eigen::Matrix4d& covariance);

}  // namespace ceilmap::registration
