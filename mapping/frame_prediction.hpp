#pragma once

#include <deque>
#include <optional>

#include "calib/base/heading.hpp"
#include "calib/base/twist2.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/wheels/relative_motion.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/odometry.hpp"

namespace ceilmap::mapping {

/// Predicted pose of a frame, before its image is processed.
struct ExpectedPose {
  Pose2 T_map_base;
  double sigma_px = 0;  ///< standard deviation of the position, pixels of the view
  double sigma_rad = 0;
  /// The yaw is predicted by the compass alone: the robot was lost, or it turned faster than the
  /// constant-velocity model predicts.
  bool by_compass_alone = false;
};

/// Predicts the pose of the next frame of a drive with a constant-velocity model. Where a compass
/// is available, it gives the turn. Only the compass' turn since the last placed frame is used:
/// earlier disturbances of the compass have no effect. Internal to the odometry.
class FramePrediction {
 public:
  /// @param view  must outlive the prediction. @param origin  T_map_base of the first frame.
  FramePrediction(const calib::CeilingView& view,
                  const Pose2& origin,
                  const OdometryParams& params);

  /// Begins a new frame with its time stamp, its heading if there is one, and the motion since the
  /// frame before by the wheels, if it is known.
  void Begin(double stamp_s,
             const std::optional<HeadingPrior>& heading,
             const std::optional<wheels::RelativeMotion>& wheels = {});
  /// A frame that is not processed, with the motion since the frame before by the wheels.
  void Skip(const std::optional<wheels::RelativeMotion>& wheels);
  /// Whether the position is unknown: since it was placed last, the robot may have moved by half an
  /// image. The current image then need not overlap the images of that time.
  [[nodiscard]] bool CeilingHidden() const;
  /// Whether the robot may still be near the images of the time when it was placed last.
  [[nodiscard]] bool MayBeNear() const;
  /// Whether a measured pose is plausible under the constant-velocity model. It rejects perceptual
  /// aliasing: poses a few tiles away or rotated by a quarter turn whose images are the same.
  [[nodiscard]] bool CanBeAt(const Pose2& T_map_base);
  /// Whether the robot would have moved, or turned, less than in the step before.
  [[nodiscard]] bool FallsBehind(const Pose2& T_map_base) const;
  /// Whether the robot would have moved, or turned, less or more than in the step before; also
  /// where there was none.
  [[nodiscard]] bool IsUneven(const Pose2& T_map_base) const;
  /// How many times the last step the robot has moved since the last placed frame, where CanBeAt is
  /// false because frames are missing that no stamp tells of: a recorder that drops frames and
  /// numbers the others. Nothing where the pose is neither on the way that the robot was driving
  /// nor straight ahead of it, as far as it can have driven at its highest speed so far.
  /// @return 2 .. 9
  [[nodiscard]] std::optional<int> StepsTo(const Pose2& T_map_base) const;
  /// Standard deviation that accounts for an implausible innovation. Where a measured position
  /// differs from the constant-velocity prediction, the image may be of another moment, or damaged
  /// without an error of its decoder, however well it fits. @return map units; 0 where the
  /// innovation is plausible. @param steps  StepsTo, if that accepted the pose.
  [[nodiscard]] double InnovationSigma(const Pose2& T_map_base, int steps = 1) const;
  /// Pose predicted from the last motion; nothing where the frame before could not be placed. After
  /// a gap in time (of three steps) the motion is unknown: AfterLoss.
  [[nodiscard]] std::optional<ExpectedPose> Next();
  /// Motion since the last placed frame by the wheels; nothing where it is not known.
  [[nodiscard]] const std::optional<wheels::RelativeMotion>& WheelMotion() const { return wheels_; }
  /// Pose predicted by the wheels since the last placed frame.
  [[nodiscard]] std::optional<ExpectedPose> ByWheels() const;
  /// Whether the robot may be at a pose by its wheels. Wheels slip: a false answer is no proof.
  [[nodiscard]] bool WheelsAgree(const Pose2& T_map_base) const;
  /// Whether frames without a pose lie between this one and the last placed one.
  [[nodiscard]] bool AfterGap() const { return !last_; }
  /// Pose predicted from the last known pose and the compass alone, after a loss; nothing without a
  /// compass. The position uncertainty grows fast with time.
  [[nodiscard]] std::optional<ExpectedPose> AfterLoss() const;
  /// Pose predicted from the motion before a short loss; nothing where too much time has passed or
  /// no motion is known. As uncertain as Next() at most.
  [[nodiscard]] std::optional<ExpectedPose> Continued() const;
  /// Whether the robot cannot be where it was placed last, after so short a time: it was driving
  /// steadily, by several pixels from frame to frame.
  [[nodiscard]] bool MustHaveMoved() const;
  /// Pose at which an unconnected segment begins: the last known position, and its yaw turned by
  /// the compass.
  [[nodiscard]] Pose2 Restart();

  /// The frame was placed. Its measured yaw is the reference of later compass turns.
  /// @param steps  StepsTo, if that accepted the pose: later predictions take the missing frames
  /// into account.
  void Placed(const Pose2& T_map_base, int steps = 1);
  void Lost();
  /// The velocity at the latest placed frame, as known from elsewhere.
  void Continue(const Twist2& velocity);

 private:
  struct PlacedFrame {
    Pose2 T_map_base;
    double stamp_s = 0;
  };
  struct Off {
    double px = 0;
    double rad = 0;
  };
  [[nodiscard]] std::optional<HeadingTurn> Turn() const;
  [[nodiscard]] double Sigma() const;
  [[nodiscard]] std::optional<int> StepsAhead(const Pose2& T_map_base) const;
  [[nodiscard]] double ElapsedSeconds() const;
  [[nodiscard]] std::optional<Off> Lag(const Pose2& T_map_base) const;
  [[nodiscard]] std::optional<Off> OffEvenMotion(const Pose2& T_map_base, double stamp_s) const;
  [[nodiscard]] Off OffFrom(const Pose2& expected, const Pose2& T_map_base) const;

  const calib::CeilingView& view_;
  const OdometryParams& params_;
  HeadingSince compass_;
  std::optional<wheels::RelativeMotion> wheels_;  // since the last placed frame
  double stamp_s_ = 0;    // of the current frame, with the time of missing frames before it
  double missing_s_ = 0;  // that time
  double gap_s_ = 0;      // from the frame before, by their stamps
  std::optional<double> given_stamp_s_;
  bool heading_ = false;  // of the current frame
  std::optional<PlacedFrame> last_;
  std::optional<PlacedFrame> before_last_;
  Pose2 T_last_placed_;  // last placed pose, of any age
  std::optional<double> last_placed_s_;
  std::deque<PlacedFrame> recent_;  // the last placed frames of this segment
  bool contradicted_ = false;       // an implausible pose was measured since the last placed frame
  double speed_px_s_ = 0;           // speed at the last placed frame
  double fastest_px_s_ = 0;         // of the recording so far
  double marked_yaw_ = 0;           // yaw of the last placed frame with a heading
  std::optional<Pose2> predicted_;  // pose of this frame by the constant-velocity model
  std::optional<double> error_px_;  // largest recent error of the predictions, decaying
};

}  // namespace ceilmap::mapping
