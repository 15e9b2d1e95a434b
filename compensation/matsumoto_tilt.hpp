#pragma once

#include <memory>

#include "calib/rig.hpp"
#include "compensation/tilt_estimate.hpp"

namespace ceilmap::compensation {

/// Pitch and roll by the method of Matsumoto et al. 2010, "Visual compensation in localization of a
/// robot on a ceiling map", as it is published: Eq. (1) is solved for each frame alone. There is no
/// filter over time, no estimate of the wall's distance and no feedback from the ceiling or a map.
/// It is the baseline of the other methods (TiltEstimator).
///
/// Of the paper: the images of the forward camera are registered by RI-POC. Their vertical shift
/// gives th1, the zoom gives th2 (ForwardEquation::SolveFromZoom), and Eq. (1) the pitch
/// theta_Dy; their rotation is the roll theta_Dx. The upward camera gives Cx: the sum of the
/// motions between adjacent frames, by RI-POC (SimilarityTracker). T_Dx and T_Dy of Eq. (2) and (3)
/// are removed from the pose by those who use the tilt (calib::LevelView).
///
/// What the paper leaves open, and how it is filled:
/// - *The second frame of Eq. (1).* The text has motions "between two adjacent frames", but the
///   equation holds only if the other frame B is level. B is the latest level frame: the first
///   frame, which is assumed to be level, then the middle one of three consecutive frames whose
///   measured pitch and roll are zero within `level_sigmas`. A new B is taken after debris, and
///   when the zoom has changed by more than 3 %. The truth is not used.
/// - *Cx* is not defined in the text. It is the motion from the frame to B that the upward camera
///   shows, along the view of the forward camera, with the error that the tilt causes.
/// - *The root.* Eq. (1) has two: the one nearest to th1 is taken.
/// - *The zoom* is used as it was registered. The keystone distortion of the tilted image, 0.5 % of
///   the zoom at 4.6 degrees, stays in it.
/// - *The pivot* `a` is that of the rear axle where the front climbs, and 0 where the rear does and
///   in Eq. (3), as the rig has no other one.
/// - *Frames that cannot be measured* (either camera covered, no root) are taken as level, with a
///   large covariance, and counted (TiltSource::kNone). After five of them in a row the next one
///   with texture in both images becomes B.
/// Not thread-safe; measures both cameras in parallel.
class MatsumotoTilt {
 public:
  /// @param level_sigmas  A frame whose pitch and roll lie within this many standard deviations of
  ///   level may become the level frame B, >= 0. Its own tilt stays as measured.
  /// @throws InputError when the rig lacks an upward or a forward camera.
  explicit MatsumotoTilt(const calib::Rig& rig, double level_sigmas = 2);
  ~MatsumotoTilt();
  MatsumotoTilt(MatsumotoTilt&&) noexcept;
  MatsumotoTilt& operator=(MatsumotoTilt&&) noexcept;

  /// @param frame  Stamps must increase. @throws InputError on an image of another size or type.
  TiltEstimate Estimate(const TiltFrame& frame);

  /// `by_ceiling`, `forward_refused` and `corrected` are 0; `keyframes` counts the level frames B.
  [[nodiscard]] const TiltReport& Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::compensation
