#include "calib/mirror_reader.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace ceilmap::calib {
namespace {

/// Tolerance for values rounded to three or four digits by hand, in m or as a fraction of 1.
constexpr double kRedundancyTolerance = 1e-3;

}  // namespace

HyperbolicMirror ParseMirror(const YamlValue& mirror, const Eigen::Isometry3d& T_base_cam) {
  if (mirror.Find("inner_radius_px") || mirror.Find("outer_radius_px")) {
    mirror.Fail("A, B, C, ... for type hyperbolic_mirror",
                "write type: mirror for a ring, when the mirror's shape is not known");
  }
  mirror.AllowOnly({"A",
                    "B",
                    "C",
                    "rim_radius",
                    "base_link_to_viewpoint",
                    "rim_radius_px",
                    "horizon_radius_px"});
  const auto positive = [&](const char* key) {
    return mirror.At(key, "it from the mirror's data sheet or calibration")
        .PositiveNumber("take it from the mirror's data sheet or calibration");
  };
  HyperbolicMirror m;
  m.A_m = positive("A");
  m.B_m = positive("B");
  m.C_m = positive("C");
  m.rim_radius_m = positive("rim_radius");
  m.rim_radius_px = positive("rim_radius_px");
  m.horizon_radius_px = positive("horizon_radius_px");
  if (std::abs(m.C_m / std::hypot(m.A_m, m.B_m) - 1) > kRedundancyTolerance) {
    mirror.At("C", "").Fail("sqrt(A^2 + B^2)", "correct A, B or C");
  }
  if (const auto viewpoint = mirror.Find("base_link_to_viewpoint")) {
    const Eigen::Vector3d given(viewpoint->Numbers(3).data());
    if ((T_base_cam * Eigen::Vector3d(0, 0, 2 * m.C_m) - given).norm() > kRedundancyTolerance) {
      viewpoint->Fail("2 C along the camera's axis from the camera", "correct it or remove it");
    }
  }
  return m;
}

MirrorRing ParseMirrorRing(const YamlValue& mirror,
                           cv::Size image,
                           const std::optional<Eigen::Vector2d>& axis_px) {
  mirror.AllowOnly({"inner_radius_px", "outer_radius_px", "centre_px"});
  constexpr auto kFix = "measure it in an image, from the mirror's centre";
  MirrorRing ring;
  ring.inner_radius_px =
      mirror.At("inner_radius_px", "the radius in the image that the robot's own body fills")
          .PositiveNumber(kFix);
  const YamlValue outer =
      mirror.At("outer_radius_px", "the radius in the image of the mirror's rim");
  ring.outer_radius_px = outer.PositiveNumber(kFix);
  if (!(ring.outer_radius_px > ring.inner_radius_px)) {
    outer.Fail("larger than inner_radius_px", "the mirror's rim is the outer circle");
  }
  ring.centre_px =
      axis_px && !mirror.Find("centre_px")
          ? *axis_px
          : Eigen::Vector2d(
                mirror.At("centre_px", "the mirror's centre [u, v] in the image, or camera_matrix")
                    .Numbers(2)
                    .data());
  const Eigen::Vector2d far_corner(image.width - 1, image.height - 1);
  const double room_px =
      std::min(ring.centre_px.minCoeff(), (far_corner - ring.centre_px).minCoeff());
  if (ring.outer_radius_px > room_px) {
    outer.Fail("a circle inside the image (at most " +
                   std::to_string(static_cast<int>(std::floor(room_px))) + " px about its centre)",
               "take a smaller one, or correct centre_px");
  }
  return ring;
}

}  // namespace ceilmap::calib
