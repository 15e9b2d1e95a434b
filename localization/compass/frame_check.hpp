#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "localization/compass/compass.hpp"

namespace ceilmap::compass {

/// Checks the frames of a run against the requirements of Compass::Next.
class FrameCheck {
 public:
  /// Checks the next frame.
  /// @throws InputError on a panorama of another size or type than before, or of one that no
  ///   compass accepts, on a stamp that does not increase, and on a travel vector that is not
  ///   finite.
  void Take(const PanoramaFrame& frame);

  /// Number of frames checked so far.
  [[nodiscard]] std::int64_t Frames() const { return frames_; }

 private:
  std::int64_t frames_ = 0;
  cv::Size size_;
  int type_ = 0;
  double stamp_s_ = 0;
};

}  // namespace ceilmap::compass
