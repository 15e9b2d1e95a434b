#include "samples/simulator/mirror_rays.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/base/degrees.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Vector3d;

/// Height of the mirror above its centre, at `radius_m` from its axis.
double MirrorHeight(const OmniCamera& camera, double radius_m) {
  return camera.mirror_a_m * std::hypot(1, radius_m / camera.mirror_b_m);
}

}  // namespace

Cone Cone::Around(const std::vector<Vector3d>& directions) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& direction : directions) sum += direction.normalized();
  Cone cone{sum.normalized(), 0};
  for (const Vector3d& direction : directions) {
    const double cosine = std::clamp(cone.axis.dot(direction.normalized()), -1.0, 1.0);
    cone.angle_rad = std::max(cone.angle_rad, std::acos(cosine));
  }
  return cone;
}

bool Cone::Intersects(const Vector3d& axis_other, double angle_other_rad) const {
  const double reach = angle_rad + angle_other_rad + 1e-6;
  return reach >= std::numbers::pi || axis.dot(axis_other) >= std::cos(reach);
}

MirrorRays::MirrorRays(const OmniCamera& camera)
    : camera_(camera),
      focus_m_(camera.FocusM()),
      cx_((camera.width_px - 1) / 2.0 + camera.centre_offset_px[0]),
      cy_((camera.height_px - 1) / 2.0 + camera.centre_offset_px[1]),
      body_z_(std::sin(camera.body_below_deg * kRadPerDeg)),
      centres_(camera.height_px, camera.width_px) {
  const float nothing = std::numeric_limits<float>::quiet_NaN();
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      const auto d = Direction(u, v);
      centres_(v, u) =
          d ? cv::Vec3f(cv::Vec3d(d->x(), d->y(), d->z())) : cv::Vec3f(nothing, nothing, nothing);
    }
  }
  MakeBlocks();
}

std::optional<Vector3d> MirrorRays::Direction(double u, double v) const {
  const double x = (u - cx_) / camera_.focal_px;
  const double y = (v - cy_) / camera_.focal_px;
  const double a2 = camera_.mirror_a_m * camera_.mirror_a_m;
  const double b2 = camera_.mirror_b_m * camera_.mirror_b_m;
  // The ray s (x, y, 1) from (0, 0, -C) hits z^2 / A^2 - r^2 / B^2 = 1 where p s^2 - 2 q s + b2 /
  // a2 = 0; the upper sheet is the farther solution if the ray is steeper than the asymptote.
  const double p = 1 / a2 - (x * x + y * y) / b2;
  const double q = focus_m_ / a2;
  const double root = q * q - p * b2 / a2;
  if (!(p > 0 && root >= 0)) return std::nullopt;
  const double s = (q + std::sqrt(root)) / p;
  if (!(s * std::hypot(x, y) <= camera_.rim_radius_m)) return std::nullopt;
  return Vector3d(s * x, s * y, s - 2 * focus_m_).normalized();
}

double MirrorRays::RimRadiusPx() const {
  const double depth = focus_m_ + MirrorHeight(camera_, camera_.rim_radius_m);
  return camera_.focal_px * camera_.rim_radius_m / depth;
}

double MirrorRays::HorizonRadiusPx() const {
  // At the height of the focus, z = C, the mirror has the radius B^2 / A.
  const double radius_m = camera_.mirror_b_m * camera_.mirror_b_m / camera_.mirror_a_m;
  return camera_.focal_px * radius_m / (2 * focus_m_);
}

double MirrorRays::RimElevation() const {
  return std::atan2(MirrorHeight(camera_, camera_.rim_radius_m) - focus_m_, camera_.rim_radius_m);
}

Eigen::Matrix3d MirrorRays::R_base_cam() const {
  // x_cam = +y_base, y_cam = -x_base, z_cam = +z_base for a camera without rotation.
  const double yaw = std::numbers::pi / 2 + camera_.mount_yaw_deg * kRadPerDeg;
  return Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix();
}

Vector3d MirrorRays::ViewpointInBase() const {
  return {camera_.mount_x_m, camera_.mount_y_m, camera_.mount_height_m + 2 * focus_m_};
}

void MirrorRays::MakeBlocks() {
  const cv::Rect all(cv::Point(), Size());
  for (int v = 0; v < all.height; v += kBlockSize) {
    for (int u = 0; u < all.width; u += kBlockSize) {
      const cv::Rect pixels = cv::Rect(u, v, kBlockSize, kBlockSize) & all;
      std::vector<Vector3d> corners;
      for (int y = pixels.y; y <= pixels.y + pixels.height; ++y) {
        for (int x = pixels.x; x <= pixels.x + pixels.width; ++x) {
          if (const auto d = Direction(x - 0.5, y - 0.5)) corners.push_back(*d);
        }
      }
      if (corners.empty()) continue;
      Block block{pixels, Cone::Around(corners)};
      // At the rim some corners are missing; the size of a pixel compensates for them.
      block.cone.angle_rad += PixelSpan();
      blocks_.push_back(block);
    }
  }
}

}  // namespace ceilmap::simulator
