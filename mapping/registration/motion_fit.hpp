#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/registration/registration.hpp"

namespace ceilmap::registration {

/// Measurement of one block: near `point` the content of the reference lies at point + shift, after
/// the current image is resampled with the current motion.
struct BlockShift {
  Eigen::Vector2d point =
      Eigen::Vector2d::Zero();  ///< block centre in the reference, from the image's centre, px
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  ///< measured, px of the reference
  /// Sharpness of the peak, relative to the sharpest one of the band: 1 in directions with full
  /// texture, near 0 along an edge. sqrt(r' S r) is the length of a residual r in pixels, weighted
  /// by the accuracy of the block.
  Eigen::Matrix2d sharpness = Eigen::Matrix2d::Identity();
  /// Weight of the block; its shift has the inverse covariance quality * sharpness up to a common
  /// factor.
  double quality = 1;
  /// Error of the shift that the interpolation of the current image is expected to cause, px of the
  /// reference. Where one image is only shifted against the other, it is the same in all blocks.
  Eigen::Vector2d sampling = Eigen::Vector2d::Zero();
  double content = 1;  ///< largest peak that the block of the reference can have, 0..1
  double peak = 0;     ///< phase agreement at the peak, 0..1
  double signal = 1;   ///< weight in a consensus, 0..1
};

struct FitParams {
  bool estimate_scale = false;
  double inlier_px = 1.0;  ///< consensus: a block agrees within this (weighted) distance
};

/// Lower limit of the standard deviation of a fit's residuals.
inline constexpr double kSigmaFloorPx = 0.01;

struct MotionFit {
  bool ok = false;
  /// Small motion of the reference: shift(p) = motion.Apply(p) - p.
  ImageMotion motion;
  /// Of (tx, ty, theta, ln scale), from the residuals as if they were independent: what limits of
  /// acceptance are compared with. The errors are larger (CovarianceOf in motion_covariance.hpp).
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  double sigma_px = 0;  ///< robust, of a fully informative block, one axis
  int inliers = 0;
  std::vector<double> weights;  ///< robust weight of each block, 0..1
};

/// Small motion on which most blocks agree, found among all pairs of blocks: for a first round, in
/// which many shifts are random. Exhaustive, so the same input always gives the same result; n^3
/// small steps for n blocks.
MotionFit FindConsensus(const std::vector<BlockShift>& blocks, const FitParams& params);

/// Least squares of the linearised small motion, shift = t + theta J p + (ln s) p, weighted by each
/// block's quality and sharpness and Tukey's biweight on a robust scale; starts from
/// `start_weights` (empty: all 1).
MotionFit FitRobust(const std::vector<BlockShift>& blocks,
                    const FitParams& params,
                    const std::vector<double>& start_weights = {});

}  // namespace ceilmap::registration
