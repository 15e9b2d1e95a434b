#pragma once

#include <deque>
#include <optional>

#include "calib/base/heading.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/odometry.hpp"

namespace ceilmap::mapping {

/// Where a frame is expected, before its image is looked at.
struct ExpectedPose {
  Pose2 T_map_base;
  double sigma_px = 0;  ///< of its place, pixels of the view
  double sigma_rad = 0;
  /// Nothing but the compass says how the robot is turned: it was out of sight, or turned faster
  /// than expected.
  bool by_compass_alone = false;
};

/// Expects the next frame of a drive: at an even speed, turned as the compass says where there is
/// one. The compass is only asked for the turn since the last placed frame: whatever disturbed it
/// before counts for nothing. Internal to the odometry.
class FramePrediction {
 public:
  /// @param view  must outlive the prediction. @param origin  of the first frame.
  FramePrediction(const calib::CeilingView& view,
                  const Pose2& origin,
                  const OdometryParams& params);

  /// A new frame: at its moment, with its heading if there is one.
  void Begin(double stamp_s, const std::optional<HeadingPrior>& heading);
  /// Whether nobody can say any more where the robot is: it could have gone half an image since it
  /// was placed last. What it sees now need not be in the images of then.
  [[nodiscard]] bool CeilingHidden() const;
  /// Whether it may have come back into sight of the images of then.
  [[nodiscard]] bool MayBeNear() const;
  /// Can it be there? Robots move evenly: what looks the same a few tiles further, or after a
  /// quarter turn, is not where it went.
  [[nodiscard]] bool CanBeAt(const Pose2& T_map_base);
  /// Robots do not jump: where one seems to, the image may be of another moment, or damaged in a
  /// way that its decoder does not see, however well it fits. @return standard deviation of that
  /// doubt, map units; 0 where the motion is an even one.
  [[nodiscard]] double InnovationSigma(const Pose2& T_map_base) const;
  /// Its pose by the speed so far; nothing where the frame before could not be placed.
  [[nodiscard]] std::optional<ExpectedPose> Next();
  /// Its pose by the last one that is known and the compass, when everything else is not known any
  /// more; nothing without a compass. The place becomes vague fast.
  [[nodiscard]] std::optional<ExpectedPose> AfterLoss() const;
  /// Where a segment begins that nothing connects: the last known place, turned by the compass.
  [[nodiscard]] Pose2 Restart();

  /// The frame was placed; its own yaw is believed from then on, the compass' next to it.
  void Placed(const Pose2& T_map_base);
  void Lost();

 private:
  struct Seen {
    Pose2 T_map_base;
    double stamp_s = 0;
  };
  struct Off {
    double px = 0;
    double rad = 0;
  };
  [[nodiscard]] std::optional<HeadingTurn> Turn() const;
  [[nodiscard]] double Sigma() const;
  [[nodiscard]] double GoneSeconds() const;
  [[nodiscard]] std::optional<Off> OffEvenMotion(const Pose2& T_map_base) const;
  [[nodiscard]] Off OffFrom(const Pose2& expected, const Pose2& T_map_base) const;

  const calib::CeilingView& view_;
  const OdometryParams& params_;
  HeadingSince compass_;
  double stamp_s_ = 0;
  bool heading_ = false;  // of the current frame
  std::optional<Seen> last_;
  std::optional<Seen> before_last_;
  Pose2 T_last_seen_;  // however long ago
  std::optional<double> last_seen_s_;
  std::deque<Seen> way_;            // the last placed frames of this segment
  bool contradicted_ = false;       // since then a frame was seen where it cannot be
  double speed_px_s_ = 0;           // then
  double marked_yaw_ = 0;           // of the last placed frame with a heading
  std::optional<Pose2> predicted_;  // where this frame was expected, at an even speed
  std::optional<double> error_px_;  // of predictions, the largest one lately, fading
};

}  // namespace ceilmap::mapping
