#include "samples/simulator/solid_in_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ceilmap::simulator {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

SolidInView::SolidInView(const Solid& solid, const Eigen::Isometry3d& T_map_cam)
    : is_round_(solid.is_round),
      R_solid_map_(solid.T_map_solid.linear().transpose()),
      low_(solid.low),
      high_(solid.high),
      camera_(ToSolid(T_map_cam.translation() - solid.T_map_solid.translation())),
      axis_((solid.low + solid.high).tail<2>() / 2),
      radius_((solid.high.y() - solid.low.y()) / 2),
      brightness_(static_cast<float>(solid.brightness)),
      contrast_(static_cast<float>(solid.contrast)),
      texture_offset_(solid.texture_offset),
      rays_low_(kInfinity, kInfinity),
      rays_high_(-kInfinity, -kInfinity) {
  const Eigen::Isometry3d T_cam_map = T_map_cam.inverse();
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p_cam = T_cam_map * Corner(solid, corner);
    if (p_cam.z() < 1e-3) {  // beside or behind the camera: may appear anywhere
      rays_low_ = {-kInfinity, -kInfinity};
      rays_high_ = {kInfinity, kInfinity};
      return;
    }
    const cv::Point2d ray(p_cam.x() / p_cam.z(), p_cam.y() / p_cam.z());
    rays_low_ = {std::min(rays_low_.x, ray.x), std::min(rays_low_.y, ray.y)};
    rays_high_ = {std::max(rays_high_.x, ray.x), std::max(rays_high_.y, ray.y)};
  }
}

bool SolidInView::MayShowIn(const cv::Rect2d& rays) const {
  return rays_high_.x >= rays.x && rays_low_.x <= rays.x + rays.width && rays_high_.y >= rays.y &&
         rays_low_.y <= rays.y + rays.height;
}

std::optional<SolidInView::Entry> SolidInView::Enter(const Eigen::Vector3d& direction,
                                                     double limit) const {
  const Eigen::Vector3d d = ToSolid(direction);
  return is_round_ ? EnterCylinder(d, limit) : EnterBox(d, limit);
}

std::optional<SolidInView::Entry> SolidInView::EnterBox(const Eigen::Vector3d& d,
                                                        double limit) const {
  Entry entry{0, -1};
  double leave = limit;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0) {  // parallel to the face
      if (camera_[axis] < low_[axis] || camera_[axis] > high_[axis]) return std::nullopt;
      continue;
    }
    const bool rising = d[axis] > 0;
    const double in = ((rising ? low_ : high_)[axis] - camera_[axis]) / d[axis];
    const double out = ((rising ? high_ : low_)[axis] - camera_[axis]) / d[axis];
    if (in > entry.distance) entry = {in, 2 * axis + (rising ? 0 : 1)};
    leave = std::min(leave, out);
  }
  if (entry.face < 0 || entry.distance >= leave) return std::nullopt;
  return entry;
}

std::optional<SolidInView::Entry> SolidInView::EnterCylinder(const Eigen::Vector3d& d,
                                                             double limit) const {
  const Eigen::Vector2d from = FromAxis(camera_);
  const Eigen::Vector2d across = d.tail<2>();
  // |from + t across|^2 = radius^2
  const double a = across.squaredNorm();
  const double b = from.dot(across);
  const double c = from.squaredNorm() - radius_ * radius_;
  const double root = b * b - a * c;
  if (root <= 0) return std::nullopt;
  Entry entry{(-b - std::sqrt(root)) / a, 2};
  double leave = std::min(limit, (-b + std::sqrt(root)) / a);
  if (d.x() == 0) {
    if (camera_.x() < low_.x() || camera_.x() > high_.x()) return std::nullopt;
  } else {
    const bool rising = d.x() > 0;
    const double in = ((rising ? low_ : high_).x() - camera_.x()) / d.x();
    const double out = ((rising ? high_ : low_).x() - camera_.x()) / d.x();
    if (in > entry.distance) entry = {in, rising ? 0 : 1};
    leave = std::min(leave, out);
  }
  if (entry.distance <= 0 || entry.distance >= leave) return std::nullopt;
  return entry;
}

Eigen::Vector2d SolidInView::OnFace(const Eigen::Vector3d& direction, const Entry& entry) const {
  const Eigen::Vector3d at = camera_ + entry.distance * ToSolid(direction);
  if (is_round_ && entry.face == 2) {
    const Eigen::Vector2d out = FromAxis(at);
    return texture_offset_ + Eigen::Vector2d(at.x(), radius_ * std::atan2(out.y(), out.x()));
  }
  switch (entry.face / 2) {
    case 0:
      return texture_offset_ + Eigen::Vector2d(at.y(), at.z());
    case 1:
      return texture_offset_ + Eigen::Vector2d(at.x(), at.z());
    default:
      return texture_offset_ + Eigen::Vector2d(at.x(), at.y());
  }
}

float SolidInView::Light(const Eigen::Vector3d& direction, const Entry& entry) const {
  if (!is_round_) {
    constexpr std::array<float, 3> kShades{0.6F, 0.75F, 1};
    return brightness_ * kShades.at(static_cast<std::size_t>(entry.face / 2));
  }
  // By the outward normal: 1 downwards, 0.7 to the sides.
  Eigen::Vector3d normal(entry.face == 0 ? -1 : 1, 0, 0);  // in the solid's frame
  if (entry.face == 2) {
    normal.x() = 0;
    normal.tail<2>() = FromAxis(camera_ + entry.distance * ToSolid(direction)) / radius_;
  }
  return brightness_ * static_cast<float>(0.7 - 0.3 * R_solid_map_.col(2).dot(normal));
}

}  // namespace ceilmap::simulator
