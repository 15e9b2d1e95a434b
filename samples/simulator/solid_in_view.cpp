#include "samples/simulator/solid_in_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ceilmap::simulator {
namespace {

/// Corners with the low and with the high value of a coordinate.
constexpr int kCorners = 8;

}  // namespace

SolidInView::SolidInView(const Solid& solid, const Eigen::Isometry3d& T_map_cam)
    : is_round_(solid.is_round),
      R_solid_map_(solid.T_map_solid.linear().transpose()),
      R_solid_cam_((R_solid_map_ * T_map_cam.linear()).cast<float>()),
      low_(solid.low),
      high_(solid.high),
      camera_(ToSolid(T_map_cam.translation() - solid.T_map_solid.translation())),
      axis_((solid.low + solid.high).tail<2>() / 2),
      radius_((solid.high.y() - solid.low.y()) / 2),
      brightness_(static_cast<float>(solid.brightness)),
      contrast_(static_cast<float>(solid.contrast)),
      texture_offset_(solid.texture_offset) {
  FindRays(solid, T_map_cam.inverse());
}

void SolidInView::FindRays(const Solid& solid, const Eigen::Isometry3d& T_cam_map) {
  int longest = 0;
  (high_ - low_).maxCoeff(&longest);
  std::array<Eigen::Vector2d, kCorners> seen;
  Eigen::Vector2d along(0, 0);
  for (int i = 0; i < kCorners; ++i) {
    const Eigen::Vector3d& p_cam = corners_.at(i) = T_cam_map * Corner(solid, i);
    is_ahead_ &= p_cam.z() > 1e-3;
    seen.at(i) = p_cam.head<2>() / p_cam.z();
    along += ((i >> longest) & 1) != 0 ? seen.at(i) : -seen.at(i);
  }
  if (!is_ahead_) return;
  if (along.norm() > 1e-9) across_ = Eigen::Vector2d(-along.y(), along.x()).normalized();
  for (const Eigen::Vector2d& ray : seen) {
    rays_.extend(Eigen::Vector3d(ray.x(), ray.y(), across_.dot(ray)));
  }
}

bool SolidInView::MayShow() const {
  return std::any_of(corners_.begin(), corners_.end(), [](const auto& p) { return p.z() > 0; });
}

// The pyramid of the rays has four sides; a solid that is beyond one of them is not in it.
bool SolidInView::CornersMayShowIn(const cv::Rect2d& rays) const {
  const auto any = [this](const auto& inside) {
    return std::any_of(corners_.begin(), corners_.end(), inside);
  };
  return any([&](const auto& p) { return p.x() > rays.x * p.z(); }) &&
         any([&](const auto& p) { return p.x() < (rays.x + rays.width) * p.z(); }) &&
         any([&](const auto& p) { return p.y() > rays.y * p.z(); }) &&
         any([&](const auto& p) { return p.y() < (rays.y + rays.height) * p.z(); });
}

bool SolidInView::MayShowIn(const cv::Rect2d& rays) const {
  if (!is_ahead_) return CornersMayShowIn(rays);
  const Eigen::Vector2d half(rays.width / 2, rays.height / 2);
  const Eigen::Vector2d centre(rays.x + half.x(), rays.y + half.y());
  const double reach = across_.cwiseAbs().dot(half);
  const double middle = across_.dot(centre);
  return rays_.max().x() >= rays.x && rays_.min().x() <= rays.x + rays.width &&
         rays_.max().y() >= rays.y && rays_.min().y() <= rays.y + rays.height &&
         rays_.max().z() >= middle - reach && rays_.min().z() <= middle + reach;
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

Eigen::Vector2d SolidInView::OnFace(const Eigen::Vector3d& at, int face) const {
  if (is_round_ && face == 2) {
    const Eigen::Vector2d out = FromAxis(at);
    return texture_offset_ + Eigen::Vector2d(at.x(), radius_ * std::atan2(out.y(), out.x()));
  }
  switch (face / 2) {
    case 0:
      return texture_offset_ + Eigen::Vector2d(at.y(), at.z());
    case 1:
      return texture_offset_ + Eigen::Vector2d(at.x(), at.z());
    default:
      return texture_offset_ + Eigen::Vector2d(at.x(), at.y());
  }
}

float SolidInView::Light(const Eigen::Vector3d& at, int face) const {
  if (!is_round_) {
    constexpr std::array<float, 3> kShades{0.6F, 0.75F, 1};
    return brightness_ * kShades.at(static_cast<std::size_t>(face / 2));
  }
  // By the outward normal: 1 downwards, 0.6 to the sides.
  Eigen::Vector3d normal(face == 0 ? -1 : 1, 0, 0);  // in the solid's frame
  if (face == 2) {
    normal.x() = 0;
    normal.tail<2>() = FromAxis(at) / radius_;
  }
  return brightness_ * static_cast<float>(0.6 - 0.4 * R_solid_map_.col(2).dot(normal));
}

}  // namespace ceilmap::simulator
