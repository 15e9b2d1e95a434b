#include "mapping/registration/level_preference.hpp"

#include <Eigen/Core>
#include <algorithm>

namespace ceilmap::registration {
namespace {

/// What a fit explains, for the same number of blocks at the same accuracy.
double QualityOf(const DepthFit& fit) {
  return fit.support / (fit.sigma_px * fit.sigma_px);
}

// Tilts are doubted in full where no more than this part of the texture agrees.
constexpr double kWeakTexture = 0.6;

}  // namespace

double TexturedInliers(const DepthFit& fit) {
  return fit.content > 0 ? fit.inlier_content / fit.content : 0;
}

void PreferLevel(const DepthFit& tilted, const DepthFit& level_fit, PlaneFit& fit) {
  constexpr double kTilted = 0.4;
  constexpr double kLevel = 0.7;
  const double level_quality = QualityOf(level_fit) / QualityOf(tilted);
  const double weakness =
      (kSoundTexture - TexturedInliers(tilted)) / (kSoundTexture - kWeakTexture);
  const double likeness = (level_quality - kTilted) / (kLevel - kTilted);
  const double doubt = std::clamp(weakness, 0.0, 1.0) * std::clamp(likeness, 0.0, 1.0);
  const Eigen::Vector2d tilt = doubt * Eigen::Vector2d(fit.motion.tilt_x, fit.motion.tilt_y);
  fit.covariance.bottomRightCorner<2, 2>() += tilt * tilt.transpose();
  fit.tilt_spread += tilt * tilt.transpose();
  if (doubt == 1) fit.motion = level_fit.motion;
}

}  // namespace ceilmap::registration
