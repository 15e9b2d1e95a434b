#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "mapping/registration/encoding.hpp"

namespace ceilmap::recordings {

/// One image of a recording.
struct Frame {
  cv::Mat image;  ///< CV_8UC1, or CV_8UC3 (BGR) with Pixels::kColour
  std::int64_t index =
      0;               ///< 0, 1, ... in the recording; includes frames that a live source dropped
  double stamp_s = 0;  ///< strictly increasing
  registration::Encoding encoding = {};
  double arrival_s = 0;  ///< of a live source: when it was decoded, by FrameSource::Now()
};

}  // namespace ceilmap::recordings
