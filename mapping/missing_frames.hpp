#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "calib/base/pose2.hpp"
#include "calib/ceiling_view.hpp"

namespace ceilmap::mapping {

/// Estimates how many frames are missing from a recording without a gap in its stamps: a recorder
/// that drops frames and numbers the others. The robot then seems to drive one step at two or three
/// times its speed, and at its own speed before and after it. A robot cannot accelerate like that.
class MissingFrames {
 public:
  /// @param view  must outlive the object.
  explicit MissingFrames(const calib::CeilingView& view) : view_(view) {}

  /// Adds a placed frame of the recording; stamps must increase.
  void Add(std::int64_t frame_index, double stamp_s, const Pose2& T_map_base);
  /// Estimated number of missing frames so far: only those between frames that were placed, while
  /// the robot drove by several pixels from frame to frame.
  [[nodiscard]] std::int64_t Count() const { return count_; }

 private:
  struct Placed {
    std::int64_t frame_index = 0;
    double stamp_s = 0;
    Pose2 T_map_base;
  };
  [[nodiscard]] std::optional<double> UsualSpeed() const;
  void AddSpeed(double px_s);

  const calib::CeilingView& view_;
  std::optional<Placed> last_;
  std::deque<double> speeds_;   // of the latest steps without a dropout, px/s
  std::deque<double> waiting_;  // steps that are too long, until the robot has its speed again
  std::int64_t count_ = 0;
};

}  // namespace ceilmap::mapping
