#include "app/robot_rig.hpp"

#include <fmt/format.h>

#include "calib/error.hpp"

namespace ceilmap::app {

const calib::MountedCamera& UpCameraOf(const calib::Rig& rig,
                                       const std::filesystem::path& file,
                                       const FrameSource& source) {
  if (!rig.up) {
    throw calib::InputError(
        fmt::format("{}: has no camera 'up'; add it under cameras", file.string()));
  }
  const cv::Size size = source.Size();
  const cv::Size expected = rig.up->camera.Size();
  if (size != expected) {
    throw calib::InputError(fmt::format(
        "{}: pictures are {}x{} px, but camera 'up' of {} has {}x{} px; use this recording's rig",
        source.Name(),
        size.width,
        size.height,
        file.string(),
        expected.width,
        expected.height));
  }
  return *rig.up;
}

}  // namespace ceilmap::app
