#include "calib/lens_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/degrees.hpp"

namespace ceilmap::calib {
namespace {

/// Distance of the principal point from the middle, as a fraction of the image's side. Calibrated
/// cameras have up to 0.05.
constexpr double kMaxOffCentre = 0.15;
constexpr double kMaxAspectError = 0.05;  // of fx / fy
/// Shortest focal length as a fraction of the image's width: that of a fisheye of 220 deg.
constexpr double kMinFocalRatio = 0.25;
constexpr double kMinFieldOfView = 5 * kRadPerDeg;
constexpr double kMaxFocalMm = 50;       // larger numbers are not a focal length in millimetres
constexpr double kMaxTangential = 0.02;  // of p1 and p2
constexpr double kMinRadiusRatio = 0.6;  // of a ray without and with the distortion
constexpr double kMaxRadiusRatio = 4;
constexpr double kMinFisheyeAngle = 80 * kRadPerDeg;  // of an image circle inside the image

bool Near(double value, double middle, double side) {
  return std::abs(value - middle) <= kMaxOffCentre * side;
}

double Middle(int side) {
  return (side - 1) / 2.0;
}

bool Alike(double a, double b, double tolerance) {
  return std::abs(a / b - 1) <= tolerance;
}

std::string SwappedFocalLength(const Lens& c) {
  const bool swapped = Near(c.fx, Middle(c.width_px), c.width_px) &&
                       Near(c.fy, Middle(c.height_px), c.height_px) &&
                       Alike(c.cx, c.cy, kMaxAspectError);
  if (!swapped) return "";
  return fmt::format(
      "fx, fy = {:g}, {:g} and cx, cy = {:g}, {:g}: are they swapped? the order is [fx, 0, cx, 0, "
      "fy, cy, 0, 0, 1]",
      c.fx,
      c.fy,
      c.cx,
      c.cy);
}

std::string SwappedSides(const Lens& c) {
  const bool swapped =
      Near(c.cx, Middle(c.height_px), c.height_px) && Near(c.cy, Middle(c.width_px), c.width_px);
  if (!swapped) return "";
  return fmt::format(
      "cx, cy = {:g}, {:g} in an image of {} x {}: are cx and cy swapped, or image_width and "
      "image_height?",
      c.cx,
      c.cy,
      c.width_px,
      c.height_px);
}

std::string OtherImageSize(const Lens& c) {
  const double width = 2 * c.cx + 1;
  const double height = 2 * c.cy + 1;
  constexpr double kTolerance = 0.1;
  constexpr double kMaxScale = 8;
  const double scale = width / c.width_px;
  if (!(scale > 1 / kMaxScale && scale < kMaxScale)) return "";
  if (!Alike(width / height, double(c.width_px) / c.height_px, kTolerance)) return "";
  return fmt::format(
      "cx, cy = {:g}, {:g} is the middle of an image of about {:.0f} x {:.0f}, not of {} x {}: are "
      "the intrinsics those of another image size? multiply fx, fy, cx, cy by {:.3g}",
      c.cx,
      c.cy,
      width,
      height,
      c.width_px,
      c.height_px,
      1 / scale);
}

std::string PrincipalPointSlip(const Lens& c) {
  const double u = Middle(c.width_px);
  const double v = Middle(c.height_px);
  if (Near(c.cx, u, c.width_px) && Near(c.cy, v, c.height_px)) return "";
  for (const auto& find : {SwappedFocalLength, SwappedSides, OtherImageSize}) {
    if (std::string slip = find(c); !slip.empty()) return slip;
  }
  return fmt::format(
      "cx, cy = {:g}, {:g} is far from the image's middle ({:g}, {:g}): both are counted from the "
      "top left pixel; are they those of another camera, or of a cropped image?",
      c.cx,
      c.cy,
      u,
      v);
}

std::string FocalLengthSlip(const Lens& c) {
  if (!Alike(c.fx, c.fy, kMaxAspectError)) {
    return fmt::format(
        "fx, fy = {:g}, {:g} differ by {:.0f} %: pixels of most cameras are square; are the "
        "intrinsics those of an image with another aspect ratio?",
        c.fx,
        c.fy,
        100 * (std::max(c.fx, c.fy) / std::min(c.fx, c.fy) - 1));
  }
  const double field_of_view = 2 * std::atan(c.width_px / (2 * c.fx));
  const bool wide = c.fx < kMinFocalRatio * std::max(c.width_px, c.height_px);
  if (!wide && field_of_view >= kMinFieldOfView) return "";
  const std::string start = fmt::format(
      "fx = {:g} px is a field of view of {:.3g} deg: ", c.fx, field_of_view * kDegPerRad);
  if (wide && c.fx <= kMaxFocalMm) {
    return start +
           "millimetres? focal lengths are in pixels: millimetres / width of the sensor in "
           "millimetres * image_width";
  }
  return start + "are the intrinsics those of another image size or camera?";
}

/// The largest distance from the principal point that the image shows, in focal lengths.
double CornerRadius(const Lens& c) {
  const double x = std::max(std::abs(c.cx), std::abs(c.width_px - 1 - c.cx));
  const double y = std::max(std::abs(c.cy), std::abs(c.height_px - 1 - c.cy));
  return std::hypot(x / c.fx, y / c.fy);
}

std::string DistortionSlip(const Lens& c) {
  if (!c.IsDistorted()) return "";
  const std::string names = fmt::format("{}", fmt::join(CoefficientNames(c.model), ", "));
  const bool fisheye = c.model == LensModel::kEquidistant;
  if (!fisheye && std::max(std::abs(c.distortion[2]), std::abs(c.distortion[3])) > kMaxTangential) {
    return fmt::format("p1, p2 = {:g}, {:g} are larger than those of a lens; the order is {}",
                       c.distortion[2],
                       c.distortion[3],
                       names);
  }
  const std::string question = fmt::format(
      "are the distortion coefficients those of another lens, or in another order than {}?", names);
  const double corner = CornerRadius(c);
  const double valid_angle = c.ValidAngle();
  const double valid = c.Radius(valid_angle);
  if (fisheye && valid_angle > kMinFisheyeAngle) return "";
  if (valid < corner) {
    return fmt::format(
        "the distortion is valid only to {:.0f} % of the distance from the principal point to the "
        "farthest corner: {}",
        100 * valid / corner,
        question);
  }
  if (fisheye) return "";
  const auto undistorted = c.Angle(corner);
  const double ratio = undistorted ? std::tan(*undistorted) / corner : 1;
  if (ratio >= kMinRadiusRatio && ratio <= kMaxRadiusRatio) return "";
  return fmt::format(
      "the distortion moves the image's corners to {:.0f} % of their distance from the principal "
      "point: {}",
      100 / ratio,
      question);
}

}  // namespace

std::string LensSlip(const Lens& camera) {
  for (const auto& find : {PrincipalPointSlip, FocalLengthSlip, DistortionSlip}) {
    if (std::string slip = find(camera); !slip.empty()) return slip;
  }
  return "";
}

std::string MirrorSlip(const Lens& camera, const HyperbolicMirror& mirror) {
  constexpr double kMaxRimM = 1;
  if (mirror.rim_radius_m > kMaxRimM) {
    return fmt::format(
        "mirror.rim_radius = {:g}: millimetres? A, B, C and rim_radius are in metres",
        mirror.rim_radius_m);
  }
  constexpr double kTolerance = 0.1;
  const double focal_px = std::sqrt(camera.fx * camera.fy);
  const double rim_px = focal_px * mirror.CameraSlope(mirror.RimElevation());
  if (!Alike(mirror.rim_radius_px, rim_px, kTolerance)) {
    return fmt::format(
        "mirror.rim_radius_px = {:g}, but by the focal length, A, B, C and rim_radius the rim "
        "appears at {:.4g} px: are some of them those of another mirror or image size?",
        mirror.rim_radius_px,
        rim_px);
  }
  const double horizon_px = focal_px * mirror.CameraSlope(0);
  if (!Alike(mirror.horizon_radius_px, horizon_px, kTolerance)) {
    return fmt::format(
        "mirror.horizon_radius_px = {:g}, but by the focal length, A, B and C the horizon appears "
        "at {:.4g} px: are some of them those of another mirror or image size?",
        mirror.horizon_radius_px,
        horizon_px);
  }
  if (2 * mirror.rim_radius_px > std::max(camera.width_px, camera.height_px)) {
    return fmt::format(
        "mirror.rim_radius_px = {:g} is larger than half of the image of {} x {}: is it of another "
        "image size?",
        mirror.rim_radius_px,
        camera.width_px,
        camera.height_px);
  }
  return "";
}

}  // namespace ceilmap::calib
