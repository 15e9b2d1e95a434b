#include "localization/robot/camera_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"

namespace ceilmap::robot {

CameraStream::CameraStream(double max_offset_s) : max_offset_s_(max_offset_s) {}

void CameraStream::Add(const Image& image) {
  if (!std::isfinite(image.stamp_s) || (last_stamp_s_ && !(image.stamp_s > *last_stamp_s_))) {
    throw InputError(fmt::format(
        "an image's time, {} s, is not later than that of the image before", image.stamp_s));
  }
  last_stamp_s_ = image.stamp_s;
  images_.push_back(image);
}

std::optional<Image> CameraStream::Nearest(double stamp_s) {
  // Only the last image that is not later, and those after it, can match this or a later frame.
  while (images_.size() > 1 && images_[1].stamp_s <= stamp_s) images_.pop_front();
  const Image* nearest = nullptr;
  double offset_s = max_offset_s_;
  for (const Image& image : images_) {
    const double distance_s = std::abs(image.stamp_s - stamp_s);
    if (distance_s > offset_s) continue;
    nearest = &image;
    offset_s = distance_s;
  }
  if (nearest == nullptr) {
    ++report_.missing;
    return std::nullopt;
  }
  ++report_.matched;
  report_.largest_offset_s = std::max(report_.largest_offset_s, offset_s);
  return *nearest;
}

}  // namespace ceilmap::robot
