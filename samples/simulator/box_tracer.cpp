#include "samples/simulator/box_tracer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace ceilmap::simulator {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double Radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

}  // namespace

Eigen::AlignedBox2d BoxInView::Ground(const Box& box) {
  const double c = std::abs(std::cos(Radians(box.yaw_deg)));
  const double s = std::abs(std::sin(Radians(box.yaw_deg)));
  const Eigen::Vector2d centre(box.x_m, box.y_m);
  const Eigen::Vector2d half(c * box.length_m + s * box.width_m,
                             s * box.length_m + c * box.width_m);
  return {centre - half / 2, centre + half / 2};
}

BoxInView::BoxInView(const Box& box, const Eigen::Isometry3d& T_map_cam)
    : cos_(std::cos(Radians(box.yaw_deg))),
      sin_(std::sin(Radians(box.yaw_deg))),
      low_(-box.length_m / 2, -box.width_m / 2, box.bottom_m),
      high_(box.length_m / 2, box.width_m / 2, box.top_m),
      camera_(ToBox(T_map_cam.translation() - Eigen::Vector3d(box.x_m, box.y_m, 0))),
      brightness_(box.brightness),
      rays_low_(kInfinity, kInfinity),
      rays_high_(-kInfinity, -kInfinity) {
  const Eigen::Isometry3d T_cam_map = T_map_cam.inverse();
  for (int corner = 0; corner < 8; ++corner) {
    const double x = (corner & 1) != 0 ? high_.x() : low_.x();
    const double y = (corner & 2) != 0 ? high_.y() : low_.y();
    const double z = (corner & 4) != 0 ? high_.z() : low_.z();
    const Eigen::Vector3d p_map(box.x_m + cos_ * x - sin_ * y, box.y_m + sin_ * x + cos_ * y, z);
    const Eigen::Vector3d p_cam = T_cam_map * p_map;
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

Eigen::Vector3d BoxInView::ToBox(const Eigen::Vector3d& v_map) const {
  return {cos_ * v_map.x() + sin_ * v_map.y(), cos_ * v_map.y() - sin_ * v_map.x(), v_map.z()};
}

bool BoxInView::MayShowIn(const cv::Rect2d& rays) const {
  return rays_high_.x >= rays.x && rays_low_.x <= rays.x + rays.width && rays_high_.y >= rays.y &&
         rays_low_.y <= rays.y + rays.height;
}

std::optional<BoxInView::Entry> BoxInView::Enter(const Eigen::Vector3d& direction,
                                                 double limit) const {
  const Eigen::Vector3d d = ToBox(direction);
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

Eigen::Vector2d BoxInView::OnFace(const Eigen::Vector3d& direction, const Entry& entry) const {
  const Eigen::Vector3d at = camera_ + entry.distance * ToBox(direction);
  switch (entry.face / 2) {
    case 0:
      return {at.y(), at.z()};
    case 1:
      return {at.x(), at.z()};
    default:
      return {at.x(), at.y()};
  }
}

float BoxInView::Light(const Entry& entry) const {
  constexpr std::array<double, 3> kShades{0.6, 0.75, 1};
  return static_cast<float>(brightness_ * kShades.at(entry.face / 2));
}

}  // namespace ceilmap::simulator
