#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/rig.hpp"
#include "compensation/ceiling_tracker.hpp"
#include "compensation/forward_solver.hpp"
#include "compensation/forward_tracker.hpp"
#include "compensation/tilt_filter.hpp"

namespace ceilmap::compensation {

/// What tilt is measured by.
enum class TiltMethod {
  kForward,  ///< the forward camera and Eq. (1), as Matsumoto et al. 2010
  kCeiling,  ///< the key-stone of the ceiling
  kFused     ///< both, by their covariances; whatever a frame has
};

struct TiltEstimatorParams {
  TiltMethod method = TiltMethod::kFused;
  CeilingTrackerParams ceiling;
  ForwardTrackerParams forward;
  ForwardSolverParams solver;
  TiltFilterParams filter;
  /// Robots stand level but for debris: a frame that noise explains, within this many standard
  /// deviations of level, has a tilt of exactly zero, ...
  double level_sigmas = 2;
  /// ... one beyond so many has the measured one, and in between a part of it. After level frames
  /// both are larger by `doubt_sigmas` where the ceiling tells: of many frames some are noisy, and
  /// a bump rises fast.
  double tilted_sigmas = 3;
  double doubt_sigmas = 1;
  /// So many level frames in a row make the one in their middle a keyframe, when one is wanted: it
  /// is neither the first nor the last one of a bump, which may be tilted unnoticed. That is when
  /// the robot has been tilted since the last one, when less than this part of its ceiling is seen,
  /// or when the forward camera has come nearer by more than this.
  int level_frames = 3;
  double renew_overlap = 0.8;
  double renew_zoom = 0.03;
  /// A tilted frame becomes the keyframe, drawn level, when less than this is seen.
  double min_overlap = 0.55;
  /// After so many frames in a row that the ceiling tells nothing of, its keyframe is given up.
  int restart_after = 5;
  /// A map's contradiction counts from this angle on, rad, and this many times in a row.
  double correct_rad = 1.5e-3;
  int correct_after = 3;
  /// Of frames that nothing measures, for however long: debris is not higher, rad.
  double unknown_sigma_rad = 0.035;
  /// Of a keyframe that had to be taken for level unseen, rad.
  double assumed_sigma_rad = 0.002;
};

/// One moment of the robot's cameras.
struct TiltFrame {
  cv::Mat up;       ///< CV_8UC1, as the camera took it
  cv::Mat forward;  ///< the same; empty: there is none
  double stamp_s = 0;
};

/// What a frame's tilt rests on.
enum class TiltSource {
  kNone,     ///< nothing was measured: the tilt is the prediction
  kForward,  ///< the forward camera
  kCeiling,
  kBoth
};

struct TiltEstimate {
  Tilt tilt;  ///< with its covariance; exactly zero, both, for a frame that the ceiling
              ///< shows to be level
  TiltSource source = TiltSource::kNone;
  /// Before any fusion: pitch and roll by one of the two alone.
  std::optional<TiltAngles> by_forward;
  std::optional<TiltAngles> by_ceiling;
};

/// What estimating took, and from what.
struct TiltReport {
  std::int64_t frames = 0;
  std::int64_t level = 0;
  std::int64_t by_ceiling = 0;  ///< frames whose ceiling told
  std::int64_t by_forward = 0;
  std::int64_t without_forward = 0;  ///< frames without a forward picture
  std::int64_t forward_refused = 0;  ///< frames whose forward camera contradicted (something moved)
  std::int64_t unknown = 0;          ///< neither told
  std::int64_t keyframes = 0;
  std::int64_t corrected = 0;  ///< keyframes that were not level (Correct)
  double largest_rad = 0;      ///< tilt
  double ceiling_ms = 0;
  double forward_ms = 0;
};

/// Pitch and roll of the robot while it drives, from its upward and forward cameras. Not
/// thread-safe; measures the two cameras side by side when both are there.
class TiltEstimator {
 public:
  /// @param rig  with an upward camera; a forward camera and its height where they are to be used.
  /// @throws InputError when the method needs what the rig does not have.
  explicit TiltEstimator(const calib::Rig& rig, const TiltEstimatorParams& params = {});
  ~TiltEstimator();
  TiltEstimator(TiltEstimator&&) noexcept;
  TiltEstimator& operator=(TiltEstimator&&) noexcept;

  /// @throws InputError on an image of another size or type, or a stamp that does not
  /// increase. Never on what an image shows.
  TiltEstimate Estimate(const TiltFrame& frame);

  /// What a level map says is left of the last frame's tilt after Estimate. Keyframes were level as
  /// far as anybody knew; when the map contradicts, again and again, they were not (a robot that
  /// was switched on with debris under a wheel), and the next frame becomes one that is.
  void Correct(const TiltAngles& left);

  [[nodiscard]] const TiltReport& Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::compensation
