#include <cmath>
#include <string>

#include "calib/camera_info.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {

void ReadAsCameraInfo(std::string_view bytes) {
  constexpr const char* kFile = "camera.yaml";
  const auto camera = Accepted([&] { return calib::ParseCameraInfo(std::string(bytes), kFile); });
  if (!camera) return;
  Require(camera->width_px > 0 && camera->height_px > 0 && camera->fx > 0 && camera->fy > 0,
          "a camera that cannot be");
  calib::CameraInfo info;
  info.lens = *camera;
  info.rectified = {camera->fx, camera->fy, camera->cx, camera->cy};
  const calib::Lens again = calib::ParseCameraInfo(calib::FormatCameraInfo(info), kFile);
  Require(again.Size() == camera->Size() && again.fx == camera->fx && again.fy == camera->fy &&
              again.cx == camera->cx && again.cy == camera->cy && again.model == camera->model &&
              again.distortion == camera->distortion,
          "a camera reads back as another one");
}

}  // namespace ceilmap::fuzz
