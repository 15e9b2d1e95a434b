#pragma once

#include <optional>

#include "calib/base/pose2.hpp"
#include "calib/base/twist2.hpp"

namespace ceilmap {

/// Velocity of the robot at the next frames, extrapolated with constant acceleration from those
/// before. It corrects images of a rolling shutter before they are registered.
class VelocityPredictor {
 public:
  /// A measured velocity. One that no robot could reach after the one before is left out once: a
  /// loop that was closed moves the pose. @param measured  later than the one before.
  void Add(const StampedTwist2& measured);
  /// The pose of a frame, or that it is not known. Two poses in succession give a velocity.
  void AddPose(const std::optional<Pose2>& T_map_base, double stamp_s);
  /// Nothing before the first velocity, and where the last one is more than 0.5 s ago.
  [[nodiscard]] std::optional<Twist2> At(double stamp_s) const;

 private:
  struct Placed {
    Pose2 T_map_base;
    double stamp_s = 0;
  };
  std::optional<Placed> placed_;
  std::optional<StampedTwist2> last_;
  std::optional<StampedTwist2> before_;
  bool left_out_ = false;  // the velocity after last_
};

}  // namespace ceilmap
