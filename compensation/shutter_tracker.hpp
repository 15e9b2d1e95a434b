#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "calib/ceiling_view.hpp"
#include "calib/level_view.hpp"
#include "compensation/ceiling_tracker.hpp"
#include "compensation/shutter_velocity.hpp"
#include "compensation/tilt_estimate.hpp"

namespace ceilmap::compensation {

/// Rectifies the images of the upward camera and measures them against the ceiling's keyframe.
/// Those of a rolling shutter need the velocity that they serve to measure: they are measured again
/// where the expected one was wrong.
class ShutterTracker {
 public:
  /// @param view, level_view, ceiling  must outlive the object.
  ShutterTracker(const calib::CeilingView& view,
                 const calib::LevelView& level_view,
                 CeilingTracker& ceiling)
      : view_(view), level_view_(level_view), ceiling_(ceiling), velocity_(view) {}

  struct Measurement {
    CeilingTracker::Frame frame;
    std::optional<CeilingMotion> motion;  ///< nothing: not measured
    /// Of the tilt that the rows of a rolling shutter show, because the velocity is not known
    /// better; contained in the motion's covariance.
    double tilt_variance = 0;
    Twist2 assumed;  ///< velocity with which the image was rectified
  };
  /// The frame before.
  struct Before {
    const CeilingTracker::Frame* frame = nullptr;  ///< nullptr: it has no pose
    bool measured = false;                         ///< false: it is the keyframe itself
  };
  Measurement Measure(const TiltFrame& frame, const Before& before);

  /// The frame measured last becomes the keyframe, without a measurement. @param assumed  velocity
  /// with which it was rectified. When the next frames show another one, it is rectified anew.
  void Begin(const TiltFrame& frame, const Twist2& assumed);
  /// Another keyframe takes its place.
  void Forget() { guess_.reset(); }
  /// The keyframe of Begin, if the frame measured last caused it to be rectified anew.
  std::optional<CorrectedImage> TakeCorrected();

 private:
  /// A keyframe that was rectified before any velocity was measured.
  struct Guess {
    cv::Mat up;  // as taken
    double stamp_s = 0;
    registration::Encoding encoding;
    Twist2 velocity;
  };

  [[nodiscard]] Pose2 Apparent(const Eigen::Isometry3d& T_reference_base) const;
  [[nodiscard]] StampedTwist2 MeanVelocity(const CeilingTracker::Frame& before,
                                           const CeilingTracker::Frame& now) const;
  [[nodiscard]] std::optional<Twist2> Expected(const TiltFrame& frame, bool followed) const;
  bool CorrectGuess(const Twist2& now, double stamp_s);

  const calib::CeilingView& view_;
  const calib::LevelView& level_view_;
  CeilingTracker& ceiling_;
  ShutterVelocity velocity_;
  std::optional<Guess> guess_;  // until the first velocity is measured
  std::optional<CorrectedImage> corrected_;
  cv::Mat rectified_;
};

}  // namespace ceilmap::compensation
