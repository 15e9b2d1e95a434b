#include "calib/nominal_rig.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/yaml_text.hpp"

namespace ceilmap::calib {
namespace {

void Check(const NominalCamera& camera) {
  const double fov_deg = camera.fov_rad * kDegPerRad;
  constexpr double kRounding = 1e-9;
  if (!(fov_deg >= NominalCamera::kMinFovDeg - kRounding &&
        fov_deg <= NominalCamera::kMaxFovDeg + kRounding)) {
    throw InputError(fmt::format("field of view = {:g} deg, must be in {:g}..{:g}",
                                 fov_deg,
                                 NominalCamera::kMinFovDeg,
                                 NominalCamera::kMaxFovDeg));
  }
  if (!(camera.camera_height_m >= 0)) {
    throw InputError(fmt::format("camera height = {:g} m, must be >= 0, above the floor",
                                 camera.camera_height_m));
  }
  if (!(camera.ceiling_height_m > camera.camera_height_m &&
        camera.ceiling_height_m <= NominalCamera::kMaxHeightM)) {
    throw InputError(
        fmt::format("ceiling height = {:g} m, must be above the camera ({:g} m) and at most {:g} m",
                    camera.ceiling_height_m,
                    camera.camera_height_m,
                    NominalCamera::kMaxHeightM));
  }
}

}  // namespace

Rig NominalRig(cv::Size size, const NominalCamera& camera) {
  Check(camera);
  const std::string focal_px = NumberText(size.width / (2 * std::tan(camera.fov_rad / 2)));
  const std::string text = fmt::format(
      "# made from a horizontal field of view of {} deg; not calibrated\n"
      "h: {}\n"
      "cameras:\n"
      "  up:\n"
      "    type: pinhole\n"
      "    image_width: {}\n"
      "    image_height: {}\n"
      "    camera_matrix: {{rows: 3, cols: 3, data: [{}, 0, {}, 0, {}, {}, 0, 0, 1]}}\n"
      "    base_link_to_camera: {{translation: [0, 0, {}]}}\n",
      NumberText(camera.fov_rad * kDegPerRad),
      NumberText(camera.ceiling_height_m),
      size.width,
      size.height,
      focal_px,
      NumberText((size.width - 1) / 2.0),
      focal_px,
      NumberText((size.height - 1) / 2.0),
      NumberText(camera.camera_height_m));
  return ParseRig(text, "nominal rig");
}

}  // namespace ceilmap::calib
