#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "calib/wheels/relative_motion.hpp"
#include "mapping/graph/keyframe.hpp"

namespace ceilmap::mapping {

/// The ways of a drive that only the wheels know: they connect what was seen before a dark stretch
/// with what was seen after it. What the wheels are worth is known better at the end of the drive.
class WheelBridges {
 public:
  /// Each frame in turn. @param edges  of the keyframe that it made. @param motion  since the frame
  /// before; nothing: it is not known.
  void Follow(bool placed,
              const std::vector<graph::Edge>& edges,
              const std::optional<wheels::RelativeMotion>& motion);
  /// Slips that the whole drive showed.
  void TakeSlips(const wheels::SlipRate& slips) { slips_ = slips; }
  /// The wheels are wrong.
  void Forget() { forgotten_ = true; }
  /// Adds the slips that were not known yet to the covariance of the edges that only the wheels
  /// know, or removes these edges when the wheels are wrong.
  void Correct(std::vector<graph::Edge>& edges) const;

 private:
  std::optional<wheels::RelativeMotion> since_placed_;
  std::unordered_map<std::int64_t, wheels::RelativeMotion> ways_;  // to these keyframes
  wheels::SlipRate slips_;
  bool forgotten_ = false;
};

}  // namespace ceilmap::mapping
