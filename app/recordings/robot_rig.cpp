#include "app/recordings/robot_rig.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"

namespace ceilmap::recordings {
namespace {

const calib::MountedCamera& CameraFor(const std::optional<calib::MountedCamera>& camera,
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

const calib::MountedCamera& UpCameraOf(const calib::Rig& rig,
                                       const std::filesystem::path& file,
                                       const FrameSource& source) {
  return CameraFor(rig.up, "up", file, source.Name(), source.Size());
}

const calib::MountedCamera& OmniCameraOf(const calib::Rig& rig,
                                         const std::filesystem::path& file,
                                         const FrameSource& source) {
  return CameraFor(rig.omni, "omni", file, source.Name(), source.Size());
}

void CheckForwardCamera(const calib::Rig& rig,
                        const std::filesystem::path& file,
                        const std::string& source,
                        cv::Size size) {
  CameraFor(rig.forward, "forward", file, source, size);
}

}  // namespace ceilmap::recordings
