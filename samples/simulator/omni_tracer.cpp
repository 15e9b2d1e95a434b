#include "samples/simulator/omni_tracer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include "samples/simulator/pixel_lattice.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

const cv::Vec3f kSurroundings(0.004F, 0.004F, 0.004F);
const cv::Vec3f kBody(0.16F, 0.14F, 0.13F);  // slightly blue
const cv::Vec3f kLens(0.01F, 0.01F, 0.01F);
constexpr double kLensBelow = -0.98;  // sine of an elevation, about -79 degrees

constexpr int kPointsInPixel = 21;

/// Half of the longer side of a pixel's footprint on the ceiling at the rim, where it is smallest;
/// the ceiling is not visible below the horizon.
double TexelSize(const Scene& scene, const MirrorRays& rays) {
  const double height_m = scene.room.height_m - scene.omni->mount_height_m;
  const double rise = std::sin(std::clamp(rays.RimElevation(), 0.2, std::numbers::pi / 2));
  return std::min(0.04, height_m / (rise * rise) * rays.PixelSpan() / 2);
}

Cone ConeOf(const Solid& solid, const Vector3d& from) {
  constexpr int kCorners = 8;
  std::vector<Vector3d> corners;
  corners.reserve(kCorners);
  for (int corner = 0; corner < kCorners; ++corner) corners.push_back(Corner(solid, corner) - from);
  Cone cone = Cone::Around(corners);
  // Only within a half space the cone around the corners contains the solid.
  if (!(cone.angle_rad < 1.5)) cone.angle_rad = std::numbers::pi;
  return cone;
}

}  // namespace

class OmniTracer::View {
 public:
  View(const OmniTracer& tracer,
       const Isometry3d& T_map_base,
       const std::vector<PaintedSolid>& movers);
  [[nodiscard]] cv::Mat Trace();

 private:
  struct Place {
    cv::Vec3f light;
    std::uint16_t surface = kNothing;
  };

  void Add(const Solid& solid, const cv::Vec3f& colour);
  void ChooseNear(const MirrorRays::Block& block);
  void TraceBlock(const MirrorRays::Block& block);
  void SmoothEdges(const MirrorRays::Block& block);
  [[nodiscard]] bool IsEdge(int u, int v) const;
  [[nodiscard]] Place TraceRay(const Vector3d& d_cam) const;
  [[nodiscard]] float CeilingLight(const Vector3d& at) const;

  const OmniTracer& tracer_;
  Vector3d viewpoint_;  // in map
  Eigen::Matrix3d R_map_cam_;
  CeilingWindow window_;
  std::vector<SolidInView> solids_;
  std::vector<cv::Vec3f> colours_;  // of solids_
  std::vector<Cone> cones_;         // of solids_, in map
  std::vector<std::size_t> near_;   // of solids_, those that may be visible in the current block
  cv::Mat_<cv::Vec3f> light_;
  cv::Mat_<std::uint16_t> surface_;
};

OmniTracer::OmniTracer(const Scene& scene, std::vector<Solid> solids)
    : solids_(std::move(solids)),
      rays_(*scene.omni),
      surfaces_(scene),
      paints_(scene.seed, solids_.size(), scene.omni->saturation),
      ceiling_(scene, TexelSize(scene, rays_)) {}

cv::Mat OmniTracer::Trace(const Isometry3d& T_map_base,
                          const std::vector<PaintedSolid>& movers) const {
  return View(*this, T_map_base, movers).Trace();
}

OmniTracer::View::View(const OmniTracer& tracer,
                       const Isometry3d& T_map_base,
                       const std::vector<PaintedSolid>& movers)
    : tracer_(tracer),
      viewpoint_(T_map_base * tracer.rays_.ViewpointInBase()),
      R_map_cam_(T_map_base.linear() * tracer.rays_.R_base_cam()),
      light_(tracer.rays_.Size(), kSurroundings),
      surface_(tracer.rays_.Size(), kNothing) {
  const Room& room = tracer.surfaces_.GetRoom();
  window_ =
      tracer.ceiling_.Window({Eigen::Vector2d(0, 0), Eigen::Vector2d(room.length_m, room.width_m)});
  for (std::size_t i = 0; i < tracer.solids_.size(); ++i) {
    Add(tracer.solids_[i], tracer.paints_.Of(RoomSurfaces::SolidSurface(i, 0)));
  }
  for (const PaintedSolid& mover : movers) Add(mover.solid, mover.colour);
}

void OmniTracer::View::Add(const Solid& solid, const cv::Vec3f& colour) {
  Isometry3d T_map_view = Isometry3d::Identity();
  T_map_view.translation() = viewpoint_;
  solids_.emplace_back(solid, T_map_view);
  colours_.push_back(colour);
  cones_.push_back(ConeOf(solid, viewpoint_));
}

void OmniTracer::View::ChooseNear(const MirrorRays::Block& block) {
  const Vector3d axis = R_map_cam_ * block.cone.axis;
  near_.clear();
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    if (cones_[i].Intersects(axis, block.cone.angle_rad)) near_.push_back(i);
  }
}

cv::Mat OmniTracer::View::Trace() {
  for (const MirrorRays::Block& block : tracer_.rays_.Blocks()) {
    ChooseNear(block);
    TraceBlock(block);
  }
  for (const MirrorRays::Block& block : tracer_.rays_.Blocks()) {
    ChooseNear(block);
    SmoothEdges(block);
  }
  return light_;
}

void OmniTracer::View::TraceBlock(const MirrorRays::Block& block) {
  const cv::Rect& pixels = block.pixels;
  for (int v = pixels.y; v < pixels.y + pixels.height; ++v) {
    for (int u = pixels.x; u < pixels.x + pixels.width; ++u) {
      const cv::Vec3f& d = tracer_.rays_.Centre(u, v);
      if (std::isnan(d[0])) continue;
      const Place place = TraceRay({d[0], d[1], d[2]});
      light_(v, u) = place.light;
      surface_(v, u) = place.surface;
    }
  }
}

bool OmniTracer::View::IsEdge(int u, int v) const {
  const std::uint16_t own = surface_(v, u);
  return (u > 0 && surface_(v, u - 1) != own) ||
         (u + 1 < surface_.cols && surface_(v, u + 1) != own) ||
         (v > 0 && surface_(v - 1, u) != own) ||
         (v + 1 < surface_.rows && surface_(v + 1, u) != own);
}

void OmniTracer::View::SmoothEdges(const MirrorRays::Block& block) {
  const cv::Rect& pixels = block.pixels;
  for (int v = pixels.y; v < pixels.y + pixels.height; ++v) {
    for (int u = pixels.x; u < pixels.x + pixels.width; ++u) {
      if (!IsEdge(u, v)) continue;
      cv::Vec3f sum(0, 0, 0);
      for (int i = 0; i < kPointsInPixel; ++i) {
        const cv::Point2d offset = LatticePoint<kPointsInPixel, 13>(i);
        const auto d = tracer_.rays_.Direction(u + offset.x, v + offset.y);
        sum += d ? TraceRay(*d).light : kSurroundings;
      }
      light_(v, u) = sum * (1.0F / kPointsInPixel);
    }
  }
}

float OmniTracer::View::CeilingLight(const Vector3d& at) const {
  const double column = at.x() / window_.pitch_x_m - 0.5 - static_cast<double>(window_.column0);
  const double row = at.y() / window_.pitch_y_m - 0.5 - static_cast<double>(window_.row0);
  const auto u = static_cast<float>(std::clamp(column, 0.0, window_.light.cols - 2.0));
  const auto v = static_cast<float>(std::clamp(row, 0.0, window_.light.rows - 2.0));
  float light = 0;
  window_.Sample(&u, &v, 1, &light);
  return light;
}

OmniTracer::View::Place OmniTracer::View::TraceRay(const Vector3d& d_cam) const {
  if (tracer_.rays_.ShowsRobot(d_cam.z())) {
    return {d_cam.z() < kLensBelow ? kLens : kBody,
            static_cast<std::uint16_t>(d_cam.z() < kLensBelow ? kNothing : kRobot)};
  }
  const RoomSurfaces& surfaces = tracer_.surfaces_;
  const Vector3d d = R_map_cam_ * d_cam;
  double distance = 0;
  Hit hit = surfaces.Trace(viewpoint_, d, tracer_.rays_.PixelSpan(), distance);
  const double to_hull = distance;
  std::size_t nearest = solids_.size();
  SolidInView::Entry entry;
  for (const std::size_t i : near_) {
    const auto candidate = solids_[i].Enter(d, distance);
    if (!candidate) continue;
    distance = candidate->distance;
    entry = *candidate;
    nearest = i;
  }
  if (nearest < solids_.size()) {
    const float light = surfaces.SolidLight(solids_[nearest], entry.distance * d, entry.face);
    return {light * colours_[nearest], RoomSurfaces::SolidSurface(nearest, entry.face)};
  }
  if (hit.surface == kCeiling) hit.light = CeilingLight(viewpoint_ + to_hull * d);
  return {hit.light * tracer_.paints_.Of(hit.surface), hit.surface};
}

}  // namespace ceilmap::simulator
