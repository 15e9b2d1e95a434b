#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "localization/robot/image.hpp"

namespace ceilmap::robot {

/// Counts of matches between upward frames and the images of another camera.
struct StreamReport {
  std::int64_t matched = 0;
  std::int64_t missing = 0;     ///< upward frames without an image at their time
  double largest_offset_s = 0;  ///< between matched images
};

/// The latest images of a camera, matched by time with the frames of the upward camera. The camera
/// may have another frame rate, start later and end sooner. Holds the images that a later frame can
/// still match: two, when images come as fast as they are asked for.
class CameraStream {
 public:
  /// @param max_offset_s  largest distance in time of a match, > 0.
  explicit CameraStream(double max_offset_s);

  /// Adds an image. @throws InputError when its time is not finite or not later than that of the
  /// image before.
  void Add(const Image& image);
  /// The image nearest in time; nothing when none is within max_offset_s. Stamps must not decrease.
  [[nodiscard]] std::optional<Image> Nearest(double stamp_s);

  [[nodiscard]] const StreamReport& Report() const { return report_; }

 private:
  double max_offset_s_;
  std::deque<Image> images_;  // by time
  std::optional<double> last_stamp_s_;
  StreamReport report_;
};

}  // namespace ceilmap::robot
