#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/base/twist2.hpp"
#include "calib/rig.hpp"
#include "compensation/ceiling_tracker.hpp"
#include "compensation/forward_solver.hpp"
#include "compensation/forward_tracker.hpp"
#include "compensation/tilt_filter.hpp"

namespace ceilmap::compensation {

/// The measurement from which the tilt is estimated.
enum class TiltMethod {
  kForward,  ///< the forward camera and Eq. (1), as Matsumoto et al. 2010
  kCeiling,  ///< the keystone (perspective) distortion of the ceiling
  kFused     ///< both, weighted by their covariances; one alone if only that is available
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

/// The images of the robot's cameras at one time.
struct TiltFrame {
  cv::Mat up;       ///< CV_8UC1, as the camera took it
  cv::Mat forward;  ///< the same; empty: no image
  double stamp_s = 0;
  /// Of the robot, for an upward camera with a rolling shutter (CeilingView::Rectify).
  Twist2 velocity = {};
};

/// The measurement on which a frame's tilt is based.
enum class TiltSource {
  kNone,     ///< nothing was measured: the tilt is the prediction
  kForward,  ///< the forward camera
  kCeiling,
  kBoth
};

struct TiltEstimate {
  Tilt tilt;  ///< with its covariance; both exactly zero for a frame that
              ///< the ceiling shows to be level
  TiltSource source = TiltSource::kNone;
  /// Pitch and roll by one camera alone, before fusion.
  std::optional<TiltAngles> by_forward;
  std::optional<TiltAngles> by_ceiling;
  /// The upward image, rectified and analysed, for those who register it next (mapping::Mapper,
  /// localization::Localizer).
  registration::AnalyzedImage up;
};

/// Counts and computing time of the estimation.
struct TiltReport {
  std::int64_t frames = 0;
  std::int64_t level = 0;
  std::int64_t by_ceiling = 0;  ///< frames measured by the ceiling
  std::int64_t by_forward = 0;
  std::int64_t without_forward = 0;  ///< frames without a forward image
  std::int64_t forward_refused = 0;  ///< forward measurements rejected (something moved)
  std::int64_t unknown = 0;          ///< frames without any measurement
  std::int64_t keyframes = 0;
  std::int64_t corrected = 0;  ///< keyframes that were not level (Correct)
  double largest_rad = 0;      ///< largest tilt
  double ceiling_ms = 0;
  double forward_ms = 0;
};

/// Pitch and roll of the robot while it drives, from its upward and forward cameras. Not
/// thread-safe. Measures the two cameras in parallel when both are present.
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

  [[nodiscard]] const TiltReport& Report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::compensation
