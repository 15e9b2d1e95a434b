#pragma once

#include "mapping/registration/depth_fit.hpp"
#include "mapping/registration/plane_motion.hpp"

namespace ceilmap::registration {

/// Tilts are believed where at least this part of the texture agrees.
inline constexpr double kSoundTexture = 0.7;

/// Part of the texture of all blocks that is in those that agree, 0..1.
double TexturedInliers(const DepthFit& fit);

/// Heights and tilts explain much alike: where much of the texture does not agree, a level robot
/// gets tilts of two degrees whose residuals look good. A true tilt of one degree leaves a level
/// camera a fifth of the quality or less, one of half a degree a half; false ones leave it a half
/// and more. Simulated: true tilts with 0.66 of the texture in agreement and more, false ones with
/// 0.62 and less.
/// @param tilted, level_fit  Fits with and without tilts. @param fit  of `tilted`; its tilts are
///   doubted, or its motion becomes that of `level_fit`.
void PreferLevel(const DepthFit& tilted, const DepthFit& level_fit, PlaneFit& fit);

}  // namespace ceilmap::registration
