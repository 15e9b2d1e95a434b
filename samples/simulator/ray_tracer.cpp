#include "samples/simulator/ray_tracer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "samples/simulator/pixel_lattice.hpp"
#include "samples/simulator/solid_in_view.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::RowVector3d;
using Eigen::Vector3d;

constexpr double kMinRise = 1e-3;  // minimum slope of a ray that hits the ceiling
constexpr int kTaps = 2 * CameraRays::kBlockSize;
static_assert(kTaps <= CeilingWindow::kMaxSamples);

constexpr int kLattice = 55;  // points in a pixel

using TapArray = std::array<float, kTaps>;

}  // namespace

/// The room relative to one camera pose.
class RayTracer::View {
 public:
  View(const RayTracer& tracer,
       const CameraRays& rays,
       const Isometry3d& T_map_cam,
       const std::vector<PaintedSolid>& movers);
  [[nodiscard]] cv::Mat Trace();

 private:
  struct Place {
    Hit hit;
    cv::Vec3f colour{1, 1, 1};  // of unit luminance; only for colour cameras
  };
  struct Footprint {
    Eigen::AlignedBox2d box;
    bool endless = false;  // some rays never reach the ceiling
  };

  [[nodiscard]] std::optional<Eigen::Vector2d> OnCeiling(double x, double y) const;
  /// True when all of the block's rays reach the ceiling before a wall.
  [[nodiscard]] bool IsBelowCeiling(const CameraRays::Block& block) const;
  [[nodiscard]] Footprint CeilingFootprint() const;
  void ChooseWindow(const Footprint& seen);
  void ChooseSolid(const Footprint& seen,
                   const Solid& solid,
                   const Eigen::AlignedBox3d& bounds,
                   const cv::Vec3f& colour);
  [[nodiscard]] cv::Mat Result() const { return coloured_.empty() ? light_ : coloured_; }
  void TraceCeilingBlock(const CameraRays::Block& block);
  void TraceMixedBlock(const CameraRays::Block& block, bool below_ceiling);
  void SmoothEdges(const CameraRays::Block& block, bool below_ceiling);
  [[nodiscard]] bool IsEdge(int u, int v) const;
  void ChooseNearSolids(const cv::Rect2d& rays);
  [[nodiscard]] Place TraceRay(double x, double y, bool below_ceiling) const;
  [[nodiscard]] float CeilingLight(double x, double y) const;

  const RayTracer& tracer_;
  const Room& room_;
  const CameraRays& rays_;
  Isometry3d T_map_cam_;
  Matrix3d R_;  // of T_map_cam
  Vector3d p_;  // the camera in map
  CeilingWindow window_;
  RowVector3d to_column_;  // of (x, y, 1); over to_depth_: column in the window
  RowVector3d to_row_;
  RowVector3d to_depth_;
  std::vector<SolidInView> solids_;
  std::vector<cv::Vec3f> colours_;  // of solids_
  std::vector<std::size_t> near_;   // of solids_, those that may be visible in the current block
  cv::Mat light_;
  cv::Mat_<cv::Vec3f> coloured_;  // the same in colours; empty for a grey camera
  cv::Mat surfaces_;              // of each tap; only for blocks with several surfaces
};

RayTracer::RayTracer(const Scene& scene,
                     std::vector<Solid> solids,
                     double texel_m,
                     double saturation)
    : solids_(std::move(solids)), surfaces_(scene), ceiling_(scene, texel_m) {
  for (const Solid& solid : solids_) bounds_.push_back(Bounds(solid));
  if (saturation > 0) paints_.emplace(scene.seed, solids_.size(), saturation);
}

cv::Mat RayTracer::Trace(const CameraRays& rays,
                         const Isometry3d& T_map_cam,
                         const std::vector<PaintedSolid>& movers) const {
  return View(*this, rays, T_map_cam, movers).Trace();
}

RayTracer::View::View(const RayTracer& tracer,
                      const CameraRays& rays,
                      const Isometry3d& T_map_cam,
                      const std::vector<PaintedSolid>& movers)
    : tracer_(tracer),
      room_(tracer.surfaces_.GetRoom()),
      rays_(rays),
      T_map_cam_(T_map_cam),
      R_(T_map_cam.linear()),
      p_(T_map_cam.translation()) {
  const Footprint seen = CeilingFootprint();
  ChooseWindow(seen);
  for (std::size_t i = 0; i < tracer.solids_.size(); ++i) {
    ChooseSolid(
        seen,
        tracer.solids_[i],
        tracer.bounds_[i],
        tracer.paints_ ? tracer.paints_->Of(RoomSurfaces::SolidSurface(i, 0)) : cv::Vec3f(1, 1, 1));
  }
  for (const PaintedSolid& mover : movers)
    ChooseSolid(seen, mover.solid, Bounds(mover.solid), mover.colour);
}

std::optional<Eigen::Vector2d> RayTracer::View::OnCeiling(double x, double y) const {
  const Vector3d direction = R_ * Vector3d(x, y, 1);
  if (!(direction.z() > kMinRise)) return std::nullopt;
  return (p_ + (room_.height_m - p_.z()) / direction.z() * direction).head<2>();
}

RayTracer::View::Footprint RayTracer::View::CeilingFootprint() const {
  Footprint seen;
  for (const CameraRays::Block& block : rays_.Blocks()) {
    const cv::Rect2d& r = block.rays;
    if (!(r.width >= 0)) continue;
    for (const double x : {r.x, r.x + r.width}) {
      for (const double y : {r.y, r.y + r.height}) {
        const auto at = OnCeiling(x, y);
        if (at) seen.box.extend(*at);
        seen.endless |= !at;
      }
    }
  }
  const Eigen::AlignedBox2d room(Eigen::Vector2d(0, 0),
                                 Eigen::Vector2d(room_.length_m, room_.width_m));
  seen.box = seen.endless ? room : seen.box.intersection(room);
  return seen;
}

void RayTracer::View::ChooseWindow(const Footprint& seen) {
  const Eigen::Vector2d low = seen.box.isEmpty() ? Eigen::Vector2d(0, 0) : seen.box.min();
  const Eigen::Vector2d high = seen.box.isEmpty() ? Eigen::Vector2d(0, 0) : seen.box.max();
  window_ = tracer_.ceiling_.Window(low.x(), low.y(), high.x(), high.y());
  // p + (h - p.z) R (x, y, 1) / (R.row(2) (x, y, 1)), as one fraction.
  const double rise = room_.height_m - p_.z();
  const auto column0 = static_cast<double>(window_.column0);
  const auto row0 = static_cast<double>(window_.row0);
  to_depth_ = R_.row(2);
  to_column_ = (rise * R_.row(0) + (p_.x() - (column0 + 0.5) * window_.pitch_x_m) * to_depth_) /
               window_.pitch_x_m;
  to_row_ = (rise * R_.row(1) + (p_.y() - (row0 + 0.5) * window_.pitch_y_m) * to_depth_) /
            window_.pitch_y_m;
}

void RayTracer::View::ChooseSolid(const Footprint& seen,
                                  const Solid& solid,
                                  const Eigen::AlignedBox3d& bounds,
                                  const cv::Vec3f& colour) {
  Eigen::AlignedBox2d region = seen.box;
  region.extend(p_.head<2>());
  const Eigen::AlignedBox2d ground(Eigen::Vector2d(bounds.min().head<2>()),
                                   Eigen::Vector2d(bounds.max().head<2>()));
  if (!region.intersects(ground)) return;
  solids_.emplace_back(solid, T_map_cam_);
  colours_.push_back(colour);
}

bool RayTracer::View::IsBelowCeiling(const CameraRays::Block& block) const {
  if (!block.whole) return false;
  const cv::Rect2d& r = block.rays;
  for (const double x : {r.x, r.x + r.width}) {
    for (const double y : {r.y, r.y + r.height}) {
      const auto at = OnCeiling(x, y);
      const bool inside =
          at && at->x() > 0 && at->x() < room_.length_m && at->y() > 0 && at->y() < room_.width_m;
      if (!inside) return false;
    }
  }
  return true;
}

void RayTracer::View::ChooseNearSolids(const cv::Rect2d& rays) {
  near_.clear();
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    if (solids_[i].MayShowIn(rays)) near_.push_back(i);
  }
}

cv::Mat RayTracer::View::Trace() {
  light_ = cv::Mat(rays_.Size(), CV_32FC1, cv::Scalar(0));
  if (tracer_.paints_) coloured_ = cv::Mat_<cv::Vec3f>(rays_.Size(), cv::Vec3f(0, 0, 0));
  std::vector<const CameraRays::Block*> mixed;
  for (const CameraRays::Block& block : rays_.Blocks()) {
    ChooseNearSolids(block.rays);
    if (near_.empty() && IsBelowCeiling(block)) {
      TraceCeilingBlock(block);
    } else {
      mixed.push_back(&block);
    }
  }
  if (mixed.empty()) return Result();
  surfaces_ = cv::Mat(rays_.Size() * 2, CV_16UC1, cv::Scalar(kCeiling));
  for (const bool smooth : {false, true}) {
    for (const CameraRays::Block* block : mixed) {
      ChooseNearSolids(block->rays);
      const bool below_ceiling = IsBelowCeiling(*block);
      smooth ? SmoothEdges(*block, below_ceiling) : TraceMixedBlock(*block, below_ceiling);
    }
  }
  return Result();
}

void RayTracer::View::TraceCeilingBlock(const CameraRays::Block& block) {
  const Eigen::RowVector3f column = to_column_.cast<float>();
  const Eigen::RowVector3f row = to_row_.cast<float>();
  const Eigen::RowVector3f depth = to_depth_.cast<float>();
  TapArray x, y, light;
  const cv::Rect& pixels = block.pixels;
  const int taps = 2 * pixels.width;
  for (int tap_row = 2 * pixels.y; tap_row < 2 * (pixels.y + pixels.height); ++tap_row) {
    rays_.TapRow(tap_row, 2 * pixels.x, taps, x.data(), y.data());
    for (int i = 0; i < taps; ++i) {
      const float scale = 1 / (depth[0] * x[i] + depth[1] * y[i] + depth[2]);
      const float u = (column[0] * x[i] + column[1] * y[i] + column[2]) * scale;
      y[i] = (row[0] * x[i] + row[1] * y[i] + row[2]) * scale;
      x[i] = u;
    }
    window_.Sample(x.data(), y.data(), taps, light.data());
    auto* out = light_.ptr<float>(tap_row / 2) + pixels.x;
    for (int i = 0; i < pixels.width; ++i) out[i] += 0.25F * (light[2 * i] + light[2 * i + 1]);
  }
  if (coloured_.empty()) return;
  const cv::Mat grey = light_(pixels);  // grey, as ceilings are
  const std::array<cv::Mat, 3> planes{grey, grey, grey};
  cv::Mat coloured = coloured_(pixels);
  cv::merge(planes.data(), planes.size(), coloured);
}

void RayTracer::View::TraceMixedBlock(const CameraRays::Block& block, bool below_ceiling) {
  std::array<float, kTaps> x{};
  std::array<float, kTaps> y{};
  const cv::Rect& pixels = block.pixels;
  for (int tap_row = 2 * pixels.y; tap_row < 2 * (pixels.y + pixels.height); ++tap_row) {
    rays_.TapRow(tap_row, 2 * pixels.x, 2 * pixels.width, x.data(), y.data());
    auto* out = light_.ptr<float>(tap_row / 2) + pixels.x;
    auto* surfaces = surfaces_.ptr<std::uint16_t>(tap_row) + std::ptrdiff_t{2} * pixels.x;
    for (int i = 0; i < 2 * pixels.width; ++i) {
      const auto [hit, colour] = TraceRay(x[i], y[i], below_ceiling);
      out[i / 2] += 0.25F * hit.light;
      if (!coloured_.empty()) {
        coloured_(tap_row / 2, pixels.x + i / 2) += 0.25F * hit.light * colour;
      }
      surfaces[i] = hit.surface;
    }
  }
}

bool RayTracer::View::IsEdge(int u, int v) const {
  const int left = std::max(0, 2 * u - 1);
  const int right = std::min(surfaces_.cols - 1, 2 * u + 2);
  const auto own = surfaces_.at<std::uint16_t>(2 * v, 2 * u);
  for (int row = std::max(0, 2 * v - 1); row <= std::min(surfaces_.rows - 1, 2 * v + 2); ++row) {
    const auto* surfaces = surfaces_.ptr<std::uint16_t>(row);
    for (int column = left; column <= right; ++column) {
      if (surfaces[column] != own) return true;
    }
  }
  return false;
}

void RayTracer::View::SmoothEdges(const CameraRays::Block& block, bool below_ceiling) {
  const cv::Rect& pixels = block.pixels;
  for (int v = pixels.y; v < pixels.y + pixels.height; ++v) {
    for (int u = pixels.x; u < pixels.x + pixels.width; ++u) {
      if (!IsEdge(u, v)) continue;
      float sum = 0;
      cv::Vec3f coloured_sum(0, 0, 0);
      for (int i = 0; i < kLattice; ++i) {
        const cv::Point2d offset = LatticePoint<kLattice, 34>(i);
        const cv::Point2d ray = rays_.Ray(u, v, offset.x, offset.y);
        const auto [hit, colour] = TraceRay(ray.x, ray.y, below_ceiling);
        sum += hit.light;
        coloured_sum += hit.light * colour;
      }
      light_.at<float>(v, u) = sum / kLattice;
      if (!coloured_.empty()) coloured_(v, u) = coloured_sum * (1.0F / kLattice);
    }
  }
}

float RayTracer::View::CeilingLight(double x, double y) const {
  const double z = to_depth_[0] * x + to_depth_[1] * y + to_depth_[2];
  const double column = (to_column_[0] * x + to_column_[1] * y + to_column_[2]) / z;
  const double row = (to_row_[0] * x + to_row_[1] * y + to_row_[2]) / z;
  const auto u = static_cast<float>(std::clamp(column, 0.0, window_.light.cols - 2.0));
  const auto v = static_cast<float>(std::clamp(row, 0.0, window_.light.rows - 2.0));
  float light = 0;
  window_.Sample(&u, &v, 1, &light);
  return light;
}

RayTracer::View::Place RayTracer::View::TraceRay(double x, double y, bool below_ceiling) const {
  if (std::isnan(x)) return {};
  const Vector3d direction = R_ * Vector3d(x, y, 1);
  double distance = (room_.height_m - p_.z()) / direction.z();
  Hit hit{0, kCeiling};
  if (!below_ceiling) {
    hit = tracer_.surfaces_.Trace(p_, direction, rays_.PixelSpan(), distance);
  }
  std::size_t nearest = solids_.size();
  SolidInView::Entry entry;
  for (const std::size_t i : near_) {
    const auto candidate = solids_[i].Enter(direction, distance);
    if (!candidate) continue;
    distance = candidate->distance;
    entry = *candidate;
    nearest = i;
    hit.surface = RoomSurfaces::SolidSurface(i, entry.face);
  }
  if (nearest < solids_.size()) {
    hit.light = tracer_.surfaces_.SolidLight(solids_[nearest], direction, entry);
    return {hit, colours_[nearest]};
  }
  if (hit.surface == kCeiling) hit.light = CeilingLight(x, y);
  return tracer_.paints_ ? Place{hit, tracer_.paints_->Of(hit.surface)} : Place{hit};
}

}  // namespace ceilmap::simulator
