#include "samples/simulator/ray_tracer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "samples/simulator/ceiling_in_view.hpp"
#include "samples/simulator/pixel_lattice.hpp"
#include "samples/simulator/ray_batch.hpp"
#include "samples/simulator/solid_in_view.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kFineLattice = 55;  // points in a pixel at an edge
constexpr int kCoarseLattice = 21;
static_assert(kFineLattice <= RayBatch::kCapacity);
static_assert(4 * CameraRays::kPartSize * CameraRays::kPartSize <= RayBatch::kCapacity);

std::vector<cv::Point2d> Lattice(EdgeQuality edges) {
  const bool fine = edges == EdgeQuality::kFine;
  std::vector<cv::Point2d> points(fine ? kFineLattice : kCoarseLattice);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int n = static_cast<int>(i);
    points[i] = fine ? LatticePoint<kFineLattice, 34>(n) : LatticePoint<kCoarseLattice, 13>(n);
  }
  return points;
}

bool Overlaps(const CameraRays::Block& block, const cv::Range& rows) {
  return block.pixels.y < rows.end && block.pixels.br().y > rows.start;
}

}  // namespace

/// The room relative to one camera pose.
class RayTracer::View {
 public:
  View(const RayTracer& tracer,
       const CameraRays& rays,
       const Isometry3d& T_map_cam,
       const std::vector<PaintedSolid>& movers,
       EdgeQuality edges,
       cv::Range rows);
  [[nodiscard]] cv::Mat Trace();

 private:
  /// A part of the image in which not only the ceiling is visible.
  struct MixedPart {
    const CameraRays::Block* block = nullptr;
    std::size_t first = 0;  // of candidates_, solids that may be visible in it
    std::size_t last = 0;
    bool below_ceiling = false;  // all of its rays reach the ceiling before a wall
  };
  /// Rays of a pixel that meet the same surface.
  struct Group {
    std::uint16_t surface = kNothing;
    std::int32_t solid = -1;
    std::int32_t face = 0;
    int count = 0;
    Vector3f at{0, 0, 0};  // sum over the rays: point of a solid, or ray to the hull; in cam
    float hull_light = 0;  // sum
  };

  [[nodiscard]] std::span<const std::int32_t> Candidates(const MixedPart& part) const {
    return std::span(candidates_).subspan(part.first, part.last - part.first);
  }
  void ChooseSolid(const Solid& solid, const Eigen::AlignedBox3d& bounds, const cv::Vec3f& colour);
  void DivideImage();
  void TraceCeiling(const CameraRays::Block& block);
  void TracePart(const MixedPart& part);
  void SmoothEdges(const MixedPart& part);
  void TracePixel(int u, int v, const MixedPart& part);
  [[nodiscard]] bool IsEdge(int u, int v) const;
  void MeetHull(bool below_ceiling);
  void MeetSolids(std::span<const std::int32_t> candidates);
  void AddTo(Group& group, int ray) const;
  [[nodiscard]] float LightOf(const Group& group) const;
  void Shade(int u, int v, float light, const Group& group);

  const RayTracer& tracer_;
  const CameraRays& rays_;
  cv::Range rows_;
  Isometry3d T_map_cam_;
  Matrix3d R_;  // of T_map_cam
  CeilingInView ceiling_;
  std::vector<cv::Point2d> lattice_;  // offsets in a pixel at an edge
  std::vector<SolidInView> solids_;
  std::vector<cv::Vec3f> colours_;  // of solids_
  std::vector<MixedPart> mixed_;
  std::vector<std::int32_t> candidates_;  // of solids_, for mixed_
  std::vector<std::int32_t> near_;        // of solids_, for one pixel
  RayBatch batch_;
  std::vector<Group> groups_;  // of one pixel
  cv::Mat_<float> light_;
  cv::Mat_<cv::Vec3f> coloured_;  // the same in colours; empty for a grey camera
  cv::Mat surfaces_;              // of each tap
};

RayTracer::RayTracer(const Scene& scene,
                     std::vector<Solid> solids,
                     double texel_m,
                     double saturation)
    : solids_(std::move(solids)), surfaces_(scene), ceiling_(scene, texel_m), ribs_(scene.ceiling) {
  for (const Solid& solid : solids_) bounds_.push_back(Bounds(solid));
  if (saturation > 0) paints_.emplace(scene.seed, solids_.size(), saturation);
}

cv::Mat RayTracer::Trace(const CameraRays& rays,
                         const Isometry3d& T_map_cam,
                         const std::vector<PaintedSolid>& movers,
                         EdgeQuality edges,
                         cv::Range rows) const {
  const cv::Range all(0, rays.Size().height);
  return View(*this, rays, T_map_cam, movers, edges, rows == cv::Range::all() ? all : rows).Trace();
}

RayTracer::View::View(const RayTracer& tracer,
                      const CameraRays& rays,
                      const Isometry3d& T_map_cam,
                      const std::vector<PaintedSolid>& movers,
                      EdgeQuality edges,
                      cv::Range rows)
    : tracer_(tracer),
      rays_(rays),
      rows_(rows),
      T_map_cam_(T_map_cam),
      R_(T_map_cam.linear()),
      ceiling_(tracer.surfaces_.GetRoom(), tracer.ceiling_, tracer.ribs_, rays, T_map_cam, rows),
      lattice_(Lattice(edges)) {
  for (std::size_t i = 0; i < tracer.solids_.size(); ++i) {
    ChooseSolid(
        tracer.solids_[i],
        tracer.bounds_[i],
        tracer.paints_ ? tracer.paints_->Of(RoomSurfaces::SolidSurface(i, 0)) : cv::Vec3f(1, 1, 1));
  }
  for (const PaintedSolid& mover : movers) {
    ChooseSolid(mover.solid, Bounds(mover.solid), mover.colour);
  }
}

void RayTracer::View::ChooseSolid(const Solid& solid,
                                  const Eigen::AlignedBox3d& bounds,
                                  const cv::Vec3f& colour) {
  Eigen::AlignedBox2d region = ceiling_.Footprint();
  region.extend(Eigen::Vector2d(T_map_cam_.translation().head<2>()));
  const Eigen::AlignedBox2d ground(Eigen::Vector2d(bounds.min().head<2>()),
                                   Eigen::Vector2d(bounds.max().head<2>()));
  if (!region.intersects(ground)) return;
  const SolidInView seen(solid, T_map_cam_);
  if (!seen.MayShow()) return;
  solids_.push_back(seen);
  colours_.push_back(colour);
}

cv::Mat RayTracer::View::Trace() {
  const cv::Range touched(std::max(0, rows_.start - CameraRays::kPartSize),
                          std::min(rays_.Size().height, rows_.end + CameraRays::kPartSize));
  light_.create(rays_.Size());
  light_.rowRange(touched).setTo(0);
  if (tracer_.paints_) {
    coloured_.create(rays_.Size());
    coloured_.rowRange(touched).setTo(cv::Scalar::all(0));
  }
  DivideImage();
  if (!mixed_.empty()) {
    surfaces_.create(rays_.Size() * 2, CV_16UC1);
    surfaces_.rowRange(2 * touched.start, 2 * touched.end).setTo(kCeiling);
  }
  for (const MixedPart& part : mixed_) TracePart(part);
  for (const MixedPart& part : mixed_) {
    if (Overlaps(*part.block, rows_)) SmoothEdges(part);
  }
  return coloured_.empty() ? cv::Mat(light_) : cv::Mat(coloured_);
}

// Blocks and parts that show only the ceiling are traced at once. Edges are found from the rows
// beside theirs.
void RayTracer::View::DivideImage() {
  const auto is_inside = [&](const CameraRays::Block& block) {
    return block.pixels.y >= rows_.start && block.pixels.br().y <= rows_.end;
  };
  const cv::Range needed(rows_.start - 1, rows_.end + 1);
  std::vector<std::int32_t> near;
  for (const CameraRays::Block& block : rays_.Blocks()) {
    if (!Overlaps(block, needed)) continue;
    near.clear();
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      if (solids_[i].MayShowIn(block.rays)) near.push_back(static_cast<std::int32_t>(i));
    }
    if (near.empty() && is_inside(block) && ceiling_.Fills(block)) {
      TraceCeiling(block);
      continue;
    }
    for (const CameraRays::Block& part : block.parts) {
      if (!Overlaps(part, needed)) continue;
      MixedPart mixed{&part, candidates_.size(), 0, ceiling_.Fills(part)};
      for (const std::int32_t i : near) {
        if (solids_[i].MayShowIn(part.rays)) candidates_.push_back(i);
      }
      mixed.last = candidates_.size();
      const bool ceiling_only = mixed.last == mixed.first && mixed.below_ceiling;
      if (!ceiling_only) {
        mixed_.push_back(mixed);
      } else if (Overlaps(part, rows_)) {
        TraceCeiling(part);
      }
    }
  }
}

void RayTracer::View::TraceCeiling(const CameraRays::Block& block) {
  constexpr int kTaps = 2 * CameraRays::kBlockSize;
  std::array<float, kTaps> x;
  std::array<float, kTaps> y;
  std::array<float, kTaps> light;
  const cv::Rect& pixels = block.pixels;
  const int taps = 2 * pixels.width;
  for (int tap_row = 2 * pixels.y; tap_row < 2 * (pixels.y + pixels.height); ++tap_row) {
    rays_.TapRow(tap_row, 2 * pixels.x, taps, x.data(), y.data());
    ceiling_.Light(x.data(), y.data(), taps, light.data());
    auto* out = light_.ptr<float>(tap_row / 2) + pixels.x;
    for (int i = 0; i < pixels.width; ++i) out[i] += 0.25F * (light[2 * i] + light[2 * i + 1]);
  }
  if (coloured_.empty()) return;
  const cv::Mat grey = light_(pixels);  // grey, as ceilings are
  const std::array<cv::Mat, 3> planes{grey, grey, grey};
  cv::Mat coloured = coloured_(pixels);
  cv::merge(planes.data(), planes.size(), coloured);
}

void RayTracer::View::MeetHull(bool below_ceiling) {
  RayBatch& rays = batch_;
  if (below_ceiling) {
    for (int i = 0; i < rays.count; ++i) rays.distance[i] = ceiling_.Distance(rays.x[i], rays.y[i]);
    std::fill_n(rays.hull_light.begin(), rays.count, 0.0F);
    std::fill_n(rays.surface.begin(), rays.count, kCeiling);
    return;
  }
  for (int i = 0; i < rays.count; ++i) {
    Hit hit;
    double distance = 0;
    if (!std::isnan(rays.x[i])) {
      hit = tracer_.surfaces_.Trace(T_map_cam_.translation(),
                                    R_ * Vector3d(rays.x[i], rays.y[i], 1),
                                    rays_.PixelSpan(),
                                    distance);
    }
    rays.distance[i] = static_cast<float>(distance);
    rays.hull_light[i] = hit.light;
    rays.surface[i] = hit.surface;
  }
}

void RayTracer::View::MeetSolids(std::span<const std::int32_t> candidates) {
  RayBatch& rays = batch_;
  std::fill_n(rays.solid.begin(), rays.count, -1);
  for (const std::int32_t i : candidates) solids_[i].EnterNearer(rays, i);
  for (int i = 0; i < rays.count; ++i) {
    if (rays.solid[i] >= 0) {
      rays.surface[i] = RoomSurfaces::SolidSurface(rays.solid[i], rays.face[i]);
    }
  }
}

void RayTracer::View::AddTo(Group& group, int ray) const {
  const float length = batch_.solid[ray] >= 0 ? batch_.distance[ray] : 1;
  group.surface = batch_.surface[ray];
  group.solid = batch_.solid[ray];
  group.face = batch_.face[ray];
  group.count += 1;
  group.at += length * Vector3f(batch_.x[ray], batch_.y[ray], 1);
  group.hull_light += batch_.hull_light[ray];
}

/// Mean light on the rays of a group.
float RayTracer::View::LightOf(const Group& group) const {
  const Vector3f at = group.at / static_cast<float>(group.count);
  if (group.solid >= 0) {
    return tracer_.surfaces_.SolidLight(solids_[group.solid], R_ * at.cast<double>(), group.face);
  }
  if (group.surface != kCeiling) return group.hull_light / static_cast<float>(group.count);
  float light = 0;
  ceiling_.Light(&at.x(), &at.y(), 1, &light);
  return light;
}

/// Adds light of the group's surface to a pixel.
void RayTracer::View::Shade(int u, int v, float light, const Group& group) {
  light_(v, u) += light;
  if (coloured_.empty()) return;
  const cv::Vec3f& colour =
      group.solid >= 0 ? colours_[group.solid] : tracer_.paints_->Of(group.surface);
  coloured_(v, u) += light * colour;
}

void RayTracer::View::TracePart(const MixedPart& part) {
  const cv::Rect& pixels = part.block->pixels;
  const int taps = 2 * pixels.width;
  batch_.count = 2 * pixels.height * taps;
  for (int row = 0; row < 2 * pixels.height; ++row) {
    rays_.TapRow(
        2 * pixels.y + row, 2 * pixels.x, taps, &batch_.x[row * taps], &batch_.y[row * taps]);
  }
  MeetHull(part.below_ceiling);
  MeetSolids(Candidates(part));
  RayBatch::Array<float> ceiling;
  const auto surfaces_end = batch_.surface.begin() + batch_.count;
  if (std::find(batch_.surface.begin(), surfaces_end, kCeiling) != surfaces_end) {
    ceiling_.Light(batch_.x.data(), batch_.y.data(), batch_.count, ceiling.data());
  }
  for (int row = 0; row < 2 * pixels.height; ++row) {
    std::copy_n(&batch_.surface[row * taps],
                taps,
                surfaces_.ptr<std::uint16_t>(2 * pixels.y + row) + std::ptrdiff_t{2} * pixels.x);
  }
  for (int v = 0; v < pixels.height; ++v) {
    for (int u = 0; u < pixels.width; ++u) {
      const int first = 2 * v * taps + 2 * u;
      const std::array<int, 4> rays{first, first + 1, first + taps, first + taps + 1};
      Group group;
      bool one = true;  // else SmoothEdges does it
      for (const int ray : rays) one &= batch_.surface[ray] == batch_.surface[first];
      if (!one) continue;
      for (const int ray : rays) AddTo(group, ray);
      float light = 0;
      if (group.surface == kCeiling) {
        for (const int ray : rays) light += ceiling[ray] / 4;
      } else {
        light = LightOf(group);
      }
      Shade(pixels.x + u, pixels.y + v, light, group);
    }
  }
}

/// True unless the taps of a pixel and those next to them show the same surface.
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

void RayTracer::View::SmoothEdges(const MixedPart& part) {
  const cv::Rect& pixels = part.block->pixels;
  for (int v = pixels.y; v < pixels.y + pixels.height; ++v) {
    for (int u = pixels.x; u < pixels.x + pixels.width; ++u) {
      if (IsEdge(u, v)) TracePixel(u, v, part);
    }
  }
}

void RayTracer::View::TracePixel(int u, int v, const MixedPart& part) {
  const cv::Point2d centre = rays_.Ray(u, v, 0, 0);
  const cv::Point2d step_u = rays_.Ray(u, v, 1, 0) - centre;
  const cv::Point2d step_v = rays_.Ray(u, v, 0, 1) - centre;
  batch_.count = 0;
  for (const cv::Point2d& offset : lattice_) {
    const cv::Point2d ray = centre + offset.x * step_u + offset.y * step_v;
    batch_.x[batch_.count] = static_cast<float>(ray.x);
    batch_.y[batch_.count++] = static_cast<float>(ray.y);
  }
  const cv::Point2d size(std::abs(step_u.x) + std::abs(step_v.x),
                         std::abs(step_u.y) + std::abs(step_v.y));
  const cv::Rect2d pixel(centre.x - size.x / 2, centre.y - size.y / 2, size.x, size.y);
  near_.clear();
  for (const std::int32_t i : Candidates(part)) {
    if (part.block->whole && !solids_[i].MayShowIn(pixel)) continue;
    near_.push_back(i);
  }
  MeetHull(part.below_ceiling);
  MeetSolids(near_);
  groups_.clear();
  for (int i = 0; i < batch_.count; ++i) {
    const auto same = std::find_if(groups_.begin(), groups_.end(), [&](const Group& group) {
      return group.surface == batch_.surface[i];
    });
    AddTo(same == groups_.end() ? groups_.emplace_back() : *same, i);
  }
  light_(v, u) = 0;
  if (!coloured_.empty()) coloured_(v, u) = {0, 0, 0};
  for (const Group& group : groups_) {
    const float share = static_cast<float>(group.count) / static_cast<float>(batch_.count);
    Shade(u, v, share * LightOf(group), group);
  }
}

}  // namespace ceilmap::simulator
