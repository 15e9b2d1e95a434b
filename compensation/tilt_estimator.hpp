#pragma once

#include <memory>

#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "compensation/forward_solver.hpp"
#include "compensation/tilt_estimate.hpp"
#include "compensation/tilt_filter.hpp"

namespace ceilmap::compensation {

/// The measurement from which the tilt is estimated.
enum class TiltMethod {
  kMatsumoto,  ///< Matsumoto et al. 2010 as published: Eq. (1) of each frame alone (MatsumotoTilt)
  kForward,    ///< the forward camera by Eq. (1), a wall distance of all frames, and a filter
  kCeiling,    ///< the keystone (perspective) distortion of the ceiling
  kFused       ///< the last two, weighted by their covariances; one if only that is available
};

struct TiltEstimatorParams {
  TiltMethod method = TiltMethod::kFused;
  ForwardSolverParams solver;
  TiltFilterParams filter;
  /// Robots are assumed level except on debris. A tilt within this many standard deviations of
  /// level is set to exactly zero.
  double level_sigmas = 2;
  /// A tilt beyond this many standard deviations is taken as measured; in between, a fraction of
  /// it. Larger than `level_sigmas`.
  double tilted_sigmas = 3;
};

/// Pitch and roll of the robot while it drives, from its upward and forward cameras. Not
/// thread-safe. Measures the two cameras in parallel when both are present. With kMatsumoto the
/// frames go to a MatsumotoTilt, of the parameters only `level_sigmas` is used, and Correct has no
/// effect.
class TiltEstimator {
 public:
  /// @param rig  A rig with an upward camera, and with a forward camera and its height if these are
  ///   used.
  /// @throws InputError when the rig lacks what the method needs.
  explicit TiltEstimator(const calib::Rig& rig, const TiltEstimatorParams& params = {});
  ~TiltEstimator();
  TiltEstimator(TiltEstimator&&) noexcept;
  TiltEstimator& operator=(TiltEstimator&&) noexcept;

  /// @throws InputError on an image of another size or type, or a stamp that does not increase. The
  ///   content of an image never causes an exception.
  TiltEstimate Estimate(const TiltFrame& frame);

  /// Takes the residual tilt of the last frame, after Estimate, measured against a level map.
  /// Keyframes are assumed level. When the map contradicts this in several consecutive frames (e.g.
  /// because the robot was switched on with debris under a wheel), the next frame becomes a
  /// keyframe with the corrected tilt.
  void Correct(const TiltAngles& left);

  /// With a rolling shutter: the keyframe at which the estimator began, if the frame estimated last
  /// showed that its velocity was not the one it had been rectified with. The estimate that was
  /// given for it holds a distorted image.
  std::optional<CorrectedImage> TakeCorrected();

  [[nodiscard]] const TiltReport& Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::compensation
