#pragma once

#include <memory>
#include <optional>

#include "localization/heading_fusion.hpp"
#include "localization/map_matcher.hpp"
#include "localization/motion_model.hpp"

namespace ceilmap::localization {

/// Follows a robot whose pose is known from frame to frame: one registration per frame, with a
/// patch of the map near the expected pose. Internal to Localizer.
class Tracker {
 public:
  /// @param matcher  Must outlive the object.
  Tracker(MapMatcher& matcher, const LocalizerParams& params);

  /// The robot is at a pose. @param velocity  As measured a moment before, if it is known.
  void Start(const PoseWithCovariance& pose,
             double stamp_s,
             const std::optional<Twist2>& velocity = std::nullopt);
  void Stop() { motion_.Stop(); }
  /// Draws the next patch anew: the view has changed.
  void ForgetPatch() { patch_.reset(); }

  /// The robot in the next frame.
  struct Found {
    MapMatch match;
    std::shared_ptr<const Patch> patch;  ///< that was matched
    /// Standard deviation of the position for a motion that is not as expected, m (Track).
    double innovation_sigma_m = 0;
    bool slipped = false;  ///< the ceiling contradicts the wheels
  };
  /// Expects the robot where its wheels say, else where it is at constant velocity. Where the
  /// ceiling is seen there only, the wheels have slipped.
  ///
  /// Robots do not jump. For an apparent jump, the image may be of another time, or damaged without
  /// an error of its decoder, even if the match is good: half of the jump is then added as a
  /// standard deviation.
  /// @param by_wheels  The pose by the wheels, if there are wheels.
  /// @return nothing where the image does not match the map near there; the motion has moved on.
  std::optional<Found> Track(double stamp_s,
                             const registration::FrameSpectrum& spectrum,
                             const std::optional<HeadingPrior>& yaw,
                             const std::optional<PoseWithCovariance>& by_wheels);

  /// Started: the robot is tracked.
  [[nodiscard]] const MotionModel& Motion() const { return motion_; }

  /// Part of the blocks that agreed in the last match; 0: there was none.
  [[nodiscard]] double UsualInliers() const { return usual_inliers_; }

 private:
  struct Candidate {
    Found found;
    double sigmas = 0;  // between the match and the expected pose
  };
  void ChoosePatch(const PoseWithCovariance& expected);
  void TakeHeading(const HeadingPrior& yaw);
  [[nodiscard]] double InnovationSigma(const MapMatch& match,
                                       const PoseWithCovariance& expected) const;
  std::optional<Candidate> MatchAt(const PoseWithCovariance& expected_pose,
                                   const registration::FrameSpectrum& spectrum);

  MapMatcher& matcher_;
  double min_overlap_;
  MotionModel motion_;
  std::shared_ptr<const Patch> patch_;  // the robot is tracked on it
  double usual_inliers_ = 0;            // part of the blocks of the last match
};

}  // namespace ceilmap::localization
