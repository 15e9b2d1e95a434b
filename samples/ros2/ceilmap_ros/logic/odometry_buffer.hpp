#pragma once

#include <deque>
#include <optional>

#include "calib/base/pose2.hpp"
#include "ceilmap_ros/logic/stamp.hpp"

namespace ceilmap_ros {

using ceilmap::Pose2;

struct OdometryPose {
  Stamp stamp = 0;
  Pose2 T_odom_base;
};

/// What the wheels know of a time.
struct OdometryAnswer {
  enum class Kind {
    kKnown,
    kNone,    ///< no odometry came at all
    kNotYet,  ///< the time is later than the last sample
    kTooOld,  ///< the time is earlier than the first sample that is kept
    kGap,     ///< the samples around the time are too far apart
  };
  Kind kind = Kind::kNone;
  Pose2 T_odom_base;  ///< with kKnown

  [[nodiscard]] bool Known() const { return kind == Kind::kKnown; }
};
const char* ToString(OdometryAnswer::Kind kind);

/// The odometry of the last ten seconds, for the pose at the time of an image. Nothing is
/// extrapolated.
class OdometryBuffer {
 public:
  /// @param sample  later than the one before, see StreamOrder.
  void Add(const OdometryPose& sample);
  void Clear() { samples_.clear(); }

  /// Between two samples the robot turns evenly. They may be half a second apart.
  [[nodiscard]] OdometryAnswer At(Stamp stamp) const;
  [[nodiscard]] std::optional<Stamp> Newest() const;

 private:
  std::deque<OdometryPose> samples_;
};

}  // namespace ceilmap_ros
