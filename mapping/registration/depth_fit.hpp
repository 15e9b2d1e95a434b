#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/registration/motion_covariance.hpp"
#include "mapping/registration/plane_motion.hpp"

namespace ceilmap::registration {

struct DepthFitParams {
  bool fit_motion = true;  ///< false: the motion is known; only the heights are wanted
  /// False: level camera at one height; tilts and height stay as they start.
  bool fit_tilt = false;
  /// Standard deviation of a fully informative block at the start, pixels. It falls to what the
  /// residuals show.
  double start_sigma_px = 1;
};

/// What a fit says of one block.
struct BlockHeight {
  double rho = 1;    ///< inverse height ratio, with what was known before (PlaneShift::rho)
  double sigma = 0;  ///< of rho
  bool inlier = false;
  /// Evidence of the block for the motion, its height being free: 0 where the block shows only an
  /// edge across the direction of travel, 1 for full texture at a known height.
  double evidence = 0;
};

struct DepthFit {
  bool ok = false;
  PlaneMotion motion;
  /// Of (x, y, height, yaw, tilt_x, tilt_y), as in PlaneFit; zero rows and columns for fixed
  /// parameters. The heights of blocks are integrated out.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  /// The same as if the blocks were independent: what limits of acceptance are compared with.
  Eigen::Matrix<double, 6, 6> spread = Eigen::Matrix<double, 6, 6>::Zero();
  double sigma_px = 0;        ///< robust standard deviation of a fully informative block, one axis
  double support = 0;         ///< sum over the inliers of peak * evidence
  double content = 0;         ///< sum over all blocks of BlockShift::content
  double inlier_content = 0;  ///< the same over the inliers
  int inliers = 0;
  std::vector<BlockHeight> blocks;  ///< of each shift

  /// Part of the texture of all blocks that is in those that agree, 0..1.
  [[nodiscard]] double TexturedInliers() const {
    return content > 0 ? inlier_content / content : 0;
  }
};

/// Motion of a camera under a ceiling with a height at every place: one rotation and one
/// translation, and for each block an inverse height ratio rho with a prior (mapping/README.md,
/// "Ceilings with depth"). The position of a block in the current image is linear in rho: an error
/// of rho moves it along the line of travel by g = d x_cur / d rho. So rho is integrated out: the
/// covariance of the residual is that of the measurement plus sigma_rho^2 g g'. Blocks of unknown
/// height determine rotation and direction only; blocks of known height determine the length too.
/// Iterated least squares with robust weights; the scale of the residuals is estimated.
/// @param shared  What the noise of the blocks has in common; nullptr: nothing. Its cost grows with
/// the square of the number of blocks.
DepthFit FitDepthMotion(const PlaneCamera& camera,
                        const std::vector<PlaneShift>& shifts,
                        const PlaneMotion& start,
                        const DepthFitParams& params = {},
                        const SharedNoise* shared = nullptr);

}  // namespace ceilmap::registration
