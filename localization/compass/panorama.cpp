#include "localization/compass/panorama.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"

namespace ceilmap::compass {

void CheckPanorama(const cv::Mat& panorama, const char* name) {
  if (panorama.rows < 1 || panorama.cols < 2 || panorama.cols > kMaxColumns) {
    throw InputError(
        fmt::format("{} panorama is {} x {} pixels, must have 2 to {} columns and at least 1 row; "
                    "unwrap it with other settings",
                    name,
                    panorama.cols,
                    panorama.rows,
                    kMaxColumns));
  }
  if (panorama.type() != CV_8UC1 && panorama.type() != CV_8UC3) {
    throw InputError(fmt::format("{} panorama is {}, must be CV_8UC1 or CV_8UC3; convert it",
                                 name,
                                 cv::typeToString(panorama.type())));
  }
}

void CheckPanoramas(const cv::Mat& reference, const cv::Mat& current) {
  CheckPanorama(reference, "reference");
  CheckPanorama(current, "current");
  if (reference.size() != current.size() || reference.type() != current.type()) {
    throw InputError(
        fmt::format("panoramas differ: reference {} x {} {}, current {} x {} {}, must be equal; "
                    "unwrap both with the same settings",
                    reference.cols,
                    reference.rows,
                    cv::typeToString(reference.type()),
                    current.cols,
                    current.rows,
                    cv::typeToString(current.type())));
  }
}

}  // namespace ceilmap::compass
