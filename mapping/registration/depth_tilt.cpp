// The part of the depth stage that measures tilts.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "mapping/registration/depth_stage.hpp"

namespace ceilmap::registration {
namespace {

// Tilts are believed where at least this part of the texture agrees, ...
constexpr double kSoundTexture = 0.7;
// ... and doubted in full where no more than this part does.
constexpr double kWeakTexture = 0.6;
// Quality of a level fit, relative to that of a tilted one: the robot is tilted, or level.
constexpr double kTilted = 0.4;
constexpr double kLevelIfWeak = 0.7;
constexpr double kTiltedIfSound = 0.6;
constexpr double kLevel = 0.8;
// Largest tilt that a level fit may explain as well, rad.
constexpr double kMaxUnseenRad = 3e-3;

/// What a fit explains, for the same number of blocks at the same accuracy.
double QualityOf(const DepthFit& fit) {
  return fit.support / (fit.sigma_px * fit.sigma_px);
}

/// Heights and tilts explain much alike. How well a level camera explains the same image, relative
/// to the tilted one, tells them apart. Tilts of debris (simulated, slow robot) left a level camera
/// 0.72 of the quality at 0.1 to 0.2 degrees, 0.5 at 0.3, 0.16 at 1; false tilts leave it 0.8 and
/// more. Where much of the texture does not agree, a tilt of one degree leaves it up to a fifth,
/// and one of half a degree a half; there, false ones leave it a half and more. Simulated: true
/// tilts with 0.66 of the texture in agreement and more.
/// @param tilted, level  Fits with and without tilts. @param fit  of `tilted`; its tilts are
///   doubted, or its motion becomes that of `level`.
void PreferLevel(const DepthFit& tilted, const DepthFit& level, PlaneFit& fit) {
  const auto part = [](double value, double none, double all) {
    return std::clamp((value - none) / (all - none), 0.0, 1.0);
  };
  const double level_quality = QualityOf(level) / QualityOf(tilted);
  const double weak = part(tilted.TexturedInliers(), kSoundTexture, kWeakTexture) *
                      part(level_quality, kTilted, kLevelIfWeak);
  const Eigen::Vector2d tilt(fit.motion.tilt_x, fit.motion.tilt_y);
  const double like = part(level_quality, kTiltedIfSound, kLevel);
  // A level camera would not explain a larger tilt as well.
  const double most = kMaxUnseenRad / std::max(kMaxUnseenRad, tilt.norm());
  const Eigen::Vector2d doubted = std::max(weak, most * like) * tilt;
  fit.covariance.bottomRightCorner<2, 2>() += doubted * doubted.transpose();
  fit.tilt_spread += doubted * doubted.transpose();
  if (std::max(weak, like) == 1) fit.motion = level.motion;
}

}  // namespace

PlaneFit DepthStage::MatchTilted(const FrameSpectrum::Data& reference,
                                 const heights::HeightField& known,
                                 const FrameSpectrum::Data& current,
                                 const PlaneMotion& start) {
  PlaneFit result;
  result.motion = start;
  SmallFit small;
  if (!Fit(reference, known, current, start, true, small)) return result;
  const DepthFit tilted = small.fit;
  result.motion = tilted.motion;
  result.covariance = tilted.spread;
  result.tilt_spread = tilted.spread.bottomRightCorner<2, 2>();
  result.sigma_px = fine_frame_.factor * tilted.sigma_px;
  result.inliers = tilted.inliers;
  result.blocks = static_cast<int>(tilted.blocks.size());
  result.ok = EnoughAgree(tilted);
  if (result.ok && FitLevel(reference, known, current, start, small)) {
    PreferLevel(tilted, small.fit, result);
    ScaleToReference(small.fit.motion, small.field);
    result.level_heights = std::make_shared<const heights::HeightField>(std::move(small.field));
  }
  return result;
}

/// The position that a level camera would have: tilt and position are correlated.
/// @param small  The tilted fit; becomes the level one. @param start  as of MatchTilted
bool DepthStage::FitLevel(const FrameSpectrum::Data& reference,
                          const heights::HeightField& known,
                          const FrameSpectrum::Data& current,
                          const PlaneMotion& start,
                          SmallFit& small) {
  const auto levelled = [](PlaneMotion motion) {
    motion.height = motion.tilt_x = motion.tilt_y = 0;
    return motion;
  };
  // A level camera sees the blocks within about a pixel of where they were measured.
  constexpr double kSamePx = 1;
  const double tilt = std::hypot(small.fit.motion.tilt_x, small.fit.motion.tilt_y);
  if (fine_camera_.focal_px * tilt < kSamePx) {
    return FitShifts(known, levelled(small.fit.motion), kSamePx, false, small);
  }
  PlaneMotion level = levelled(start);
  if (small.fit.TexturedInliers() < kSoundTexture) {
    // A start that is far off would speak against a level camera.
    small.fit = FitRough(reference, known, current, level, false);
    if (small.fit.ok) level = small.fit.motion;
  }
  small.fit.motion = level;
  return FitSmall(reference, known, current, false, small);
}

}  // namespace ceilmap::registration
