#include "calib/robot_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"

namespace ceilmap::calib {
namespace {

struct Ratios {
  double x = 1;
  double y = 1;
};

Ratios RatiosOf(cv::Size from, cv::Size to) {
  return {static_cast<double>(to.width) / from.width, static_cast<double>(to.height) / from.height};
}

// The image's corner is at (-0.5, -0.5) in both sizes.
double ScaledPixel(double pixel, double ratio) {
  return (pixel + 0.5) * ratio - 0.5;
}

// One side has the length that follows from the other one. Encoders round to even numbers.
bool IsScaled(cv::Size from, cv::Size to) {
  constexpr double kRoundingPx = 2;
  const Ratios ratios = RatiosOf(from, to);
  return std::min(std::abs(to.width - ratios.y * from.width),
                  std::abs(to.height - ratios.x * from.height)) <= kRoundingPx;
}

// Half a pixel of the border may be lost, so that the circle stays inside the image.
MirrorRing ScaledTo(const MirrorRing& ring, cv::Size from, cv::Size to) {
  const Ratios ratios = RatiosOf(from, to);
  const double ratio = std::sqrt(ratios.x * ratios.y);
  MirrorRing scaled;
  scaled.centre_px = {ScaledPixel(ring.centre_px.x(), ratios.x),
                      ScaledPixel(ring.centre_px.y(), ratios.y)};
  const Eigen::Vector2d far_corner(to.width - 1, to.height - 1);
  const double room_px =
      std::min(scaled.centre_px.minCoeff(), (far_corner - scaled.centre_px).minCoeff());
  scaled.inner_radius_px = ratio * ring.inner_radius_px;
  scaled.outer_radius_px = std::min(ratio * ring.outer_radius_px, room_px);
  return scaled;
}

MountedCamera ScaledTo(const MountedCamera& mounted, cv::Size size) {
  const cv::Size from = mounted.camera.Size();
  MountedCamera scaled = mounted;
  scaled.camera = ScaledTo(mounted.camera, size);
  if (mounted.view && mounted.view->size) {
    const Ratios ratios = RatiosOf(from, size);
    scaled.view->size = cv::Size(cvRound(ratios.x * mounted.view->size->width),
                                 cvRound(ratios.y * mounted.view->size->height));
  }
  if (mounted.mirror_ring) scaled.mirror_ring = ScaledTo(*mounted.mirror_ring, from, size);
  if (scaled.mirror) {
    const Ratios ratios = RatiosOf(from, size);
    const double ratio = std::sqrt(ratios.x * ratios.y);
    scaled.mirror->rim_radius_px *= ratio;
    scaled.mirror->horizon_radius_px *= ratio;
  }
  return scaled;
}

const char* LikelyCause(cv::Size rig, cv::Size recording) {
  const cv::Size turned(recording.height, recording.width);
  return IsScaled(rig, turned) ? "is the recording turned by 90 degrees?"
                               : "it is cropped or of another camera; use this recording's rig";
}

std::optional<CameraScaling> Fit(std::optional<MountedCamera>& camera,
                                 const char* name,
                                 const std::filesystem::path& file,
                                 const std::string& source,
                                 cv::Size size) {
  if (!camera) {
    throw InputError(
        fmt::format("{}: has no camera '{}'; add it under cameras", file.string(), name));
  }
  const cv::Size expected = camera->camera.Size();
  if (size == expected) return std::nullopt;
  if (size.empty() || !IsScaled(expected, size)) {
    throw InputError(fmt::format("{}: images are {}x{} px, but camera '{}' of {} has {}x{} px; {}",
                                 source,
                                 size.width,
                                 size.height,
                                 name,
                                 file.string(),
                                 expected.width,
                                 expected.height,
                                 LikelyCause(expected, size)));
  }
  camera = ScaledTo(*camera, size);
  return CameraScaling{name, source, expected, size};
}

}  // namespace

std::string CameraScaling::Text() const {
  const Ratios ratios = RatiosOf(rig_size, size);
  return fmt::format(
      "the rig's camera '{}' has {}x{} px, {} {}x{}: its intrinsics are scaled by {:.4g}",
      camera,
      rig_size.width,
      rig_size.height,
      source,
      size.width,
      size.height,
      std::sqrt(ratios.x * ratios.y));
}

Lens ScaledTo(const Lens& camera, cv::Size size) {
  const Ratios ratios = RatiosOf(camera.Size(), size);
  Lens scaled = camera;
  scaled.width_px = size.width;
  scaled.height_px = size.height;
  scaled.fx = ratios.x * camera.fx;
  scaled.fy = ratios.y * camera.fy;
  scaled.cx = ScaledPixel(camera.cx, ratios.x);
  scaled.cy = ScaledPixel(camera.cy, ratios.y);
  return scaled;
}

std::optional<CameraScaling> FitUpCamera(Rig& rig, const std::string& source, cv::Size size) {
  return Fit(rig.up, "up", rig.file, source, size);
}

std::optional<CameraScaling> FitForwardCamera(Rig& rig, const std::string& source, cv::Size size) {
  return Fit(rig.forward, "forward", rig.file, source, size);
}

std::optional<CameraScaling> FitOmniCamera(Rig& rig, const std::string& source, cv::Size size) {
  return Fit(rig.omni, "omni", rig.file, source, size);
}

}  // namespace ceilmap::calib
