#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core.hpp>
#include <optional>

#include "ceilmap_ros/logic/stamp.hpp"

namespace ceilmap_ros {

/// An image of the ceiling that waits for its turn.
struct WaitingFrame {
  cv::Mat grey;
  Stamp stamp = 0;    ///< of the exposure
  Stamp arrival = 0;  ///< by the clock of the node
};

/// The images that are not processed yet. Only the newest one that is ready is of use for a robot
/// that moves; the older ones are dropped and counted. A newer image that still waits for the
/// odometry or the other images of its time stays.
class FrameQueue {
 public:
  /// @param frame  later than the one before. Of more than 30 images the oldest is dropped.
  void Add(WaitingFrame frame);
  void Clear();

  /// The newest image that is ready: what belongs to it is there, or it has waited long enough.
  /// @param complete_until  up to this time all that belongs to an image has come; nothing: no
  /// other
  ///   sensor sends anything, and nothing is waited for.
  /// @param longest_wait  from the arrival of an image on.
  std::optional<WaitingFrame> TakeReady(std::optional<Stamp> complete_until,
                                        Stamp now,
                                        Stamp longest_wait);

  [[nodiscard]] std::int64_t Dropped() const { return dropped_; }

 private:
  std::deque<WaitingFrame> frames_;
  std::int64_t dropped_ = 0;
};

}  // namespace ceilmap_ros
