#include "samples/simulator/ceiling_in_view.hpp"

#include <algorithm>
#include <array>

namespace ceilmap::simulator {
namespace {

using Eigen::AlignedBox2d;
using Eigen::RowVector3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMinRise = 1e-3;  // minimum slope of a ray that hits the ceiling

}  // namespace

CeilingInView::CeilingInView(const Room& room,
                             const CeilingTexture& texture,
                             const CameraRays& rays,
                             const Eigen::Isometry3d& T_map_cam)
    : room_(room),
      R_map_cam_(T_map_cam.linear()),
      camera_(T_map_cam.translation()),
      rise_(static_cast<float>(room.height_m - camera_.z())) {
  FindFootprint(rays);
  const Vector2d low = footprint_.isEmpty() ? Vector2d(0, 0) : footprint_.min();
  const Vector2d high = footprint_.isEmpty() ? Vector2d(0, 0) : footprint_.max();
  window_ = texture.Window(low.x(), low.y(), high.x(), high.y());
  // p + (h - p.z) R (x, y, 1) / (R.row(2) (x, y, 1)), as one fraction.
  const double rise = room.height_m - camera_.z();
  const auto column0 = static_cast<double>(window_.column0);
  const auto row0 = static_cast<double>(window_.row0);
  const RowVector3d depth = R_map_cam_.row(2);
  const RowVector3d column =
      rise * R_map_cam_.row(0) + (camera_.x() - (column0 + 0.5) * window_.pitch_x_m) * depth;
  const RowVector3d row =
      rise * R_map_cam_.row(1) + (camera_.y() - (row0 + 0.5) * window_.pitch_y_m) * depth;
  to_depth_ = depth.cast<float>();
  to_column_ = (column / window_.pitch_x_m).cast<float>();
  to_row_ = (row / window_.pitch_y_m).cast<float>();
}

std::optional<Vector2d> CeilingInView::At(double x, double y) const {
  const Vector3d direction = R_map_cam_ * Vector3d(x, y, 1);
  if (!(direction.z() > kMinRise)) return std::nullopt;
  return (camera_ + (room_.height_m - camera_.z()) / direction.z() * direction).head<2>();
}

void CeilingInView::FindFootprint(const CameraRays& rays) {
  const AlignedBox2d room(Vector2d(0, 0), Vector2d(room_.length_m, room_.width_m));
  bool endless = false;  // some rays never reach the ceiling
  for (const CameraRays::Block& block : rays.Blocks()) {
    const cv::Rect2d& r = block.rays;
    if (!(r.width >= 0)) continue;
    for (const double x : {r.x, r.x + r.width}) {
      for (const double y : {r.y, r.y + r.height}) {
        const auto at = At(x, y);
        if (at) footprint_.extend(*at);
        endless |= !at;
      }
    }
  }
  footprint_ = endless ? room : footprint_.intersection(room);
}

bool CeilingInView::Fills(const CameraRays::Block& block) const {
  if (!block.whole) return false;
  const cv::Rect2d& r = block.rays;
  for (const double x : {r.x, r.x + r.width}) {
    for (const double y : {r.y, r.y + r.height}) {
      const auto at = At(x, y);
      const bool inside =
          at && at->x() > 0 && at->x() < room_.length_m && at->y() > 0 && at->y() < room_.width_m;
      if (!inside) return false;
    }
  }
  return true;
}

void CeilingInView::Light(const float* x, const float* y, int count, float* light) const {
  std::array<float, CeilingWindow::kMaxSamples> u;
  std::array<float, CeilingWindow::kMaxSamples> v;
  const auto max_u = static_cast<float>(window_.light.cols - 2);
  const auto max_v = static_cast<float>(window_.light.rows - 2);
  const auto within = [](float value, float most) {  // 0 if it is not a number
    const float positive = value > 0 ? value : 0;
    return positive < most ? positive : most;
  };
  for (int first = 0; first < count; first += CeilingWindow::kMaxSamples) {
    const int n = std::min(count - first, CeilingWindow::kMaxSamples);
    for (int i = 0; i < n; ++i) {
      const float a = x[first + i];
      const float b = y[first + i];
      const float scale = 1 / (to_depth_[0] * a + to_depth_[1] * b + to_depth_[2]);
      u[i] = within((to_column_[0] * a + to_column_[1] * b + to_column_[2]) * scale, max_u);
      v[i] = within((to_row_[0] * a + to_row_[1] * b + to_row_[2]) * scale, max_v);
    }
    window_.Sample(u.data(), v.data(), n, light + first);
  }
}

}  // namespace ceilmap::simulator
