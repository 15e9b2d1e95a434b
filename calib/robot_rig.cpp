#include "calib/robot_rig.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"

namespace ceilmap::calib {
namespace {

const MountedCamera& CameraFor(const std::optional<MountedCamera>& camera,
                               const char* name,
                               const std::filesystem::path& file,
                               const std::string& source,
                               cv::Size size) {
  if (!camera) {
    throw InputError(
        fmt::format("{}: has no camera '{}'; add it under cameras", file.string(), name));
  }
  const cv::Size expected = camera->camera.Size();
  if (size != expected) {
    throw InputError(fmt::format(
        "{}: images are {}x{} px, but camera '{}' of {} has {}x{} px; use this recording's rig",
        source,
        size.width,
        size.height,
        name,
        file.string(),
        expected.width,
        expected.height));
  }
  return *camera;
}

}  // namespace

const MountedCamera& UpCameraFor(const Rig& rig, const std::string& source, cv::Size size) {
  return CameraFor(rig.up, "up", rig.file, source, size);
}

const MountedCamera& ForwardCameraFor(const Rig& rig, const std::string& source, cv::Size size) {
  return CameraFor(rig.forward, "forward", rig.file, source, size);
}

const MountedCamera& OmniCameraFor(const Rig& rig, const std::string& source, cv::Size size) {
  return CameraFor(rig.omni, "omni", rig.file, source, size);
}

}  // namespace ceilmap::calib
