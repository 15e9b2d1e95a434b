#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "mapping/registration/encoding.hpp"

namespace ceilmap::robot {

/// An image as the camera took it, of the size that the rig states; calib::FitUpCamera and its
/// siblings scale a rig to another size. The pixels are shared, not copied: do not write to them
/// afterwards.
struct Image {
  cv::Mat pixels;          ///< CV_8UC1; forward and mirror camera: also CV_8UC3 (BGR)
  double stamp_s = 0;      ///< middle of the exposure; one clock for all sensors
  std::int64_t index = 0;  ///< upward camera: number of the frame, stored with its pose
  /// Upward camera, where the image was decoded from a video, as network cameras send it. A robot
  /// is then localized also at a low bitrate, and not by what the codec did not show.
  registration::Encoding encoding = {};
};

}  // namespace ceilmap::robot
