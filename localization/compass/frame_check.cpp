#include "localization/compass/frame_check.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/base/error.hpp"
#include "localization/compass/panorama.hpp"

namespace ceilmap::compass {

void FrameCheck::Take(const PanoramaFrame& frame) {
  const cv::Mat& panorama = frame.panorama;
  CheckPanorama(panorama, "the");
  constexpr int kMinColumns = 8;
  if (panorama.cols < kMinColumns) {
    throw InputError(
        fmt::format("a panorama of {} columns is too narrow for a compass, must have at least {}; "
                    "unwrap it to more columns",
                    panorama.cols,
                    kMinColumns));
  }
  if (frames_ > 0 && (panorama.size() != size_ || panorama.type() != type_)) {
    throw InputError(
        fmt::format("panorama {} is {} x {} {}, those before are {} x {} {}; unwrap all with the "
                    "same settings",
                    frames_,
                    panorama.cols,
                    panorama.rows,
                    cv::typeToString(panorama.type()),
                    size_.width,
                    size_.height,
                    cv::typeToString(type_)));
  }
  if (!std::isfinite(frame.stamp_s) || (frames_ > 0 && !(frame.stamp_s > stamp_s_))) {
    throw InputError(fmt::format(
        "panorama {}: time {} s is not later than the one before", frames_, frame.stamp_s));
  }
  if (frame.travel && !frame.travel->allFinite()) {
    throw InputError(fmt::format("panorama {}: travel ({}, {}), must be finite",
                                 frames_,
                                 frame.travel->x(),
                                 frame.travel->y()));
  }
  if (frame.turn && !(std::isfinite(frame.turn->turn_rad) && frame.turn->noise_rad2 >= 0 &&
                      std::isfinite(frame.turn->Variance()))) {
    throw InputError(
        fmt::format("panorama {}: turn {} rad with a variance of {} rad^2, must be finite, the "
                    "variance >= 0",
                    frames_,
                    frame.turn->turn_rad,
                    frame.turn->Variance()));
  }
  size_ = panorama.size();
  type_ = panorama.type();
  stamp_s_ = frame.stamp_s;
  ++frames_;
}

}  // namespace ceilmap::compass
