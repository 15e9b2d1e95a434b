#include "samples/simulator/ceiling_in_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace ceilmap::simulator {
namespace {

using Eigen::AlignedBox2d;
using Eigen::RowVector3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMinRise = 1e-3;  // minimum slope of a ray that hits the ceiling
constexpr double kEndless = std::numeric_limits<double>::infinity();

}  // namespace

CeilingInView::CeilingInView(const Room& room,
                             const CeilingTexture& texture,
                             const DeckRibs& ribs,
                             const CameraRays& rays,
                             const Eigen::Isometry3d& T_map_cam,
                             cv::Range rows)
    : room_(room),
      ribs_(ribs),
      pixel_span_(static_cast<float>(rays.PixelSpan())),
      R_map_cam_(T_map_cam.linear()),
      camera_(T_map_cam.translation()),
      rise_(static_cast<float>(room.height_m - camera_.z())) {
  if (ribs.Exist()) {
    rib_phase_ = static_cast<float>(std::fmod(camera_.y(), ribs.EveryM()));
  }
  const AlignedBox2d ceiling(Vector2d(0, 0), Vector2d(room.length_m, room.width_m));
  for (const CameraRays::Block& block : rays.Blocks()) footprint_.extend(FootprintOf(block, 0));
  footprint_ = footprint_.intersection(ceiling);
  std::vector<AlignedBox2d> needed;
  for (const CameraRays::Block& block : rays.Blocks()) {
    for (const CameraRays::Block& part : block.parts) {
      if (part.pixels.y > rows.end || part.pixels.br().y < rows.start) continue;
      AlignedBox2d seen = FootprintOf(part, 0);
      if (ribs.Exist()) seen.extend(FootprintOf(part, ribs.DepthM()));
      needed.push_back(seen.intersection(ceiling));
    }
  }
  const AlignedBox2d nothing(Vector2d(0, 0), Vector2d(0, 0));
  window_ = texture.Window(footprint_.isEmpty() ? nothing : footprint_, needed);
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

std::optional<Vector2d> CeilingInView::At(double x, double y, double above_m) const {
  const Vector3d direction = R_map_cam_ * Vector3d(x, y, 1);
  if (!(direction.z() > kMinRise)) return std::nullopt;
  const double rise = room_.height_m + above_m - camera_.z();
  return (camera_ + rise / direction.z() * direction).head<2>();
}

AlignedBox2d CeilingInView::FootprintOf(const CameraRays::Block& block, double above_m) const {
  AlignedBox2d footprint;
  const cv::Rect2d& r = block.rays;
  if (!(r.width >= 0)) return footprint;
  for (const double x : {r.x, r.x + r.width}) {
    for (const double y : {r.y, r.y + r.height}) {
      const auto at = At(x, y, above_m);
      if (!at) return {Vector2d::Constant(-kEndless), Vector2d::Constant(kEndless)};
      footprint.extend(*at);
    }
  }
  return footprint;
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

void CeilingInView::Find(
    const float* x, const float* y, int count, float* column, float* row) const {
  for (int i = 0; i < count; ++i) {
    const float scale = 1 / (to_depth_[0] * x[i] + to_depth_[1] * y[i] + to_depth_[2]);
    column[i] = (to_column_[0] * x[i] + to_column_[1] * y[i] + to_column_[2]) * scale;
    row[i] = (to_row_[0] * x[i] + to_row_[1] * y[i] + to_row_[2]) * scale;
  }
}

void CeilingInView::FindOnRibs(
    const float* x, const float* y, int count, float* column, float* row, float* shade) const {
  const Eigen::RowVector3f to_x = R_map_cam_.row(0).cast<float>();
  const Eigen::RowVector3f to_y = R_map_cam_.row(1).cast<float>();
  const auto columns_per_m = static_cast<float>(1 / window_.pitch_x_m);
  const auto rows_per_m = static_cast<float>(1 / window_.pitch_y_m);
  std::array<float, CeilingWindow::kMaxSamples> slope{};
  std::array<float, CeilingWindow::kMaxSamples> at{};
  std::array<float, CeilingWindow::kMaxSamples> footprint{};
  std::array<float, CeilingWindow::kMaxSamples> rise{};
  for (int i = 0; i < count; ++i) {
    const float scale = 1 / (to_depth_[0] * x[i] + to_depth_[1] * y[i] + to_depth_[2]);
    slope[i] = (to_y[0] * x[i] + to_y[1] * y[i] + to_y[2]) * scale;
    at[i] = rib_phase_ + rise_ * slope[i];
    footprint[i] = 0.5F * rise_ * pixel_span_ * scale * scale;  // of one of a pixel's four taps
  }
  const auto widest = static_cast<float>(ribs_.EveryM() / 2);
  for (int i = 0; i < count; ++i) footprint[i] = std::min(footprint[i], widest);
  ribs_.See(at.data(), slope.data(), footprint.data(), count, shade, rise.data());
  for (int i = 0; i < count; ++i) {
    const float scale = 1 / (to_depth_[0] * x[i] + to_depth_[1] * y[i] + to_depth_[2]);
    column[i] += rise[i] * columns_per_m * scale * (to_x[0] * x[i] + to_x[1] * y[i] + to_x[2]);
    row[i] += rise[i] * rows_per_m * slope[i];
  }
}

void CeilingInView::Light(const float* x, const float* y, int count, float* light) const {
  std::array<float, CeilingWindow::kMaxSamples> column;
  std::array<float, CeilingWindow::kMaxSamples> row;
  std::array<float, CeilingWindow::kMaxSamples> shade;
  const auto max_column = static_cast<float>(window_.light.cols - 2);
  const auto max_row = static_cast<float>(window_.light.rows - 2);
  const auto within = [](float value, float most) {  // 0 if it is not a number
    const float positive = value > 0 ? value : 0;
    return positive < most ? positive : most;
  };
  for (int first = 0; first < count; first += CeilingWindow::kMaxSamples) {
    const int n = std::min(count - first, CeilingWindow::kMaxSamples);
    Find(x + first, y + first, n, column.data(), row.data());
    if (ribs_.Exist()) {
      FindOnRibs(x + first, y + first, n, column.data(), row.data(), shade.data());
    }
    for (int i = 0; i < n; ++i) {
      column[i] = within(column[i], max_column);
      row[i] = within(row[i], max_row);
    }
    window_.Sample(column.data(), row.data(), n, light + first);
    if (!ribs_.Exist()) continue;
    for (int i = 0; i < n; ++i) light[first + i] *= shade[i];
  }
}

}  // namespace ceilmap::simulator
