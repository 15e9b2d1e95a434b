#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "localization/compass/compass.hpp"

namespace ceilmap::compass {

/// Holds the frames of a run against what Compass::Next asks of them.
class FrameCheck {
 public:
  /// Takes the next frame.
  /// @throws InputError on a panorama of another size or type than before, or one that no
  ///   compass can take, on a stamp that does not increase, and a direction that is not finite.
  void Take(const PanoramaFrame& frame);

  /// Taken so far.
  [[nodiscard]] std::int64_t Frames() const { return frames_; }

 private:
  std::int64_t frames_ = 0;
  cv::Size size_;
  int type_ = 0;
  double stamp_s_ = 0;
};

}  // namespace ceilmap::compass
