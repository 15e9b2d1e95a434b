#include "localization/map_patches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "calib/base/lru_cache.hpp"
#include "localization/keyframe_drawing.hpp"
#include "mapping/mosaic/view_placement.hpp"

namespace ceilmap::localization {

namespace {

// Distance between the poses for which patches are drawn, as a fraction of the shorter side of
// the camera's view, (0, 1).
constexpr double kSpacingRatio = 0.2;
constexpr int kHeadingCount = 16;    // drawn at each place, [4, 255]
constexpr double kMinContent = 0.3;  // patches with a smaller mapped fraction are not used, (0, 1]
constexpr int kKeptPatches = 6;      // in memory, about 4 MB each for 640 x 480 px, >= 2

/// Point of the lattice.
struct Node {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t heading = 0;

  /// One key for all; places repeat only after 2^27 steps.
  [[nodiscard]] std::int64_t Key(bool other_light) const {
    constexpr std::int64_t kPlaces = std::int64_t{1} << 27;
    const auto wrapped = [](std::int64_t v) { return (v % kPlaces + kPlaces) % kPlaces; };
    constexpr std::int64_t kHeadings = 512;
    return (wrapped(x) * kPlaces + wrapped(y)) * kHeadings + heading +
           (other_light ? kHeadings / 2 : 0);
  }
};

/// From the centre of the image.
cv::Point2d PrincipalOf(const calib::CeilingView& view) {
  const Eigen::Vector2d principal = registration::PlaneCameraOf(view).principal_px;
  return {principal.x(), principal.y()};
}

/// Heights of a patch that shows enough depth.
void SetHeights(const cv::Mat& ratios,
                const registration::Registrar& registrar,
                registration::FrameSpectrum& spectrum) {
  heights::HeightField field = DepthDrawing::Field(ratios, registrar.EmptyHeights());
  constexpr double kMinDepthRatio = 0.05;
  if (field.DepthRatio() < kMinDepthRatio) return;
  spectrum.SetHeights(std::make_shared<const heights::HeightField>(std::move(field)));
}

}  // namespace

struct MapPatches::Impl {
  const store::MapReader& map;
  const calib::CeilingView& view;
  registration::Registrar& registrar;
  const DepthDrawing* depth;
  KeyframeDrawing keyframes;
  double spacing = 0;  // map units
  LruCache<std::shared_ptr<const Patch>> patches;
  cv::Mat grey;
  cv::Mat mask;
  std::vector<store::Look> looks;
  bool other_light = false;

  [[nodiscard]] Node NodeNear(const Pose2& T_map_base) const;
  [[nodiscard]] Pose2 PoseOf(const Node& node) const;
  [[nodiscard]] mosaic::ViewPlacement PlacementAt(const Pose2& T_map_base) const;
  [[nodiscard]] cv::Rect WindowOf(const cv::Rect2d& bounds, double margin) const;
  void DrawLooks(const cv::Rect& window, cv::Mat& to) const;
  void DrawPlane(const mosaic::ViewPlacement& placement, cv::Mat& to, cv::Mat& content) const;
};

Node MapPatches::Impl::NodeNear(const Pose2& T_map_base) const {
  const double step = 2 * std::numbers::pi / kHeadingCount;
  const std::int64_t heading = std::llround(T_map_base.yaw / step);
  constexpr double kFarthest = 1e9;  // steps; nothing is mapped there
  return {std::llround(std::clamp(T_map_base.x / spacing, -kFarthest, kFarthest)),
          std::llround(std::clamp(T_map_base.y / spacing, -kFarthest, kFarthest)),
          (heading + kHeadingCount) % kHeadingCount};
}

Pose2 MapPatches::Impl::PoseOf(const Node& node) const {
  const double step = 2 * std::numbers::pi / kHeadingCount;
  return {static_cast<double>(node.x) * spacing,
          static_cast<double>(node.y) * spacing,
          WrapAngle(static_cast<double>(node.heading) * step)};
}

MapPatches::MapPatches(const store::MapReader& map,
                       const calib::CeilingView& view,
                       registration::Registrar& registrar,
                       const DepthDrawing* depth,
                       std::vector<store::Look> looks) {
  const double shorter = std::min(view.Size().width, view.Size().height) * view.MetresPerPixel();
  impl_ = std::make_unique<Impl>(
      Impl{map,
           view,
           registrar,
           depth,
           KeyframeDrawing(map, depth),
           kSpacingRatio * shorter,
           LruCache<std::shared_ptr<const Patch>>(static_cast<std::size_t>(kKeptPatches)),
           {},
           {},
           std::move(looks)});
}
MapPatches::~MapPatches() = default;

void MapPatches::SetOtherLight(bool other) {
  impl_->other_light = other;
}

bool MapPatches::DependsOnLight(const Pose2& T_map_base) const {
  const Impl& me = *impl_;
  if (me.looks.empty() || (me.depth != nullptr && me.depth->HasDepth())) return false;
  const cv::Rect window = me.WindowOf(me.PlacementAt(T_map_base).Bounds(), 0);
  return std::any_of(me.looks.begin(), me.looks.end(), [&](const store::Look& look) {
    const cv::Rect common = window & cv::Rect(look.origin_px, look.image.size());
    return !common.empty() && cv::countNonZero(look.image(common - look.origin_px)) > 0;
  });
}

mosaic::ViewPlacement MapPatches::Impl::PlacementAt(const Pose2& T_map_base) const {
  return {T_map_base * view.T_base_view(), view.Size(), view.MetresPerPixel(), PrincipalOf(view)};
}

/// Of the mosaic.
cv::Rect MapPatches::Impl::WindowOf(const cv::Rect2d& bounds, double margin) const {
  const store::MosaicGrid& grid = map.Grid();
  const auto column = [&](double x) {
    return static_cast<int>(
        std::clamp((x - grid.min_x) / grid.resolution, 0.0, 1.0 * grid.width_px));
  };
  const auto row = [&](double y) {
    return static_cast<int>(
        std::clamp((grid.max_y - y) / grid.resolution, 0.0, 1.0 * grid.height_px));
  };
  return {cv::Point(column(bounds.x - margin), row(bounds.br().y + margin)),
          cv::Point(column(bounds.br().x + margin), row(bounds.y - margin))};
}

/// @param to  pixels of this window of the mosaic.
void MapPatches::Impl::DrawLooks(const cv::Rect& window, cv::Mat& to) const {
  for (const store::Look& look : looks) {
    const cv::Rect common = window & cv::Rect(look.origin_px, look.image.size());
    if (common.empty()) continue;
    const cv::Mat pixels = look.image(common - look.origin_px);
    pixels.copyTo(to(common - window.tl()), pixels != 0);
  }
}

std::shared_ptr<const Patch> MapPatches::Near(const Pose2& T_map_base) {
  Impl& me = *impl_;
  const Node node = me.NodeNear(T_map_base);
  const std::int64_t key = node.Key(me.other_light);
  if (const auto* known = me.patches.Find(key)) return *known;
  std::shared_ptr<const Patch> result = Exactly(me.PoseOf(node));
  me.patches.Insert(key, result);
  return result;
}

std::shared_ptr<const Patch> MapPatches::Exactly(const Pose2& T_map_base) {
  Impl& me = *impl_;
  Patch patch;
  patch.T_map_base = T_map_base;
  const cv::Mat ratios = Draw(T_map_base, me.grey, me.mask);
  patch.content = cv::countNonZero(me.mask) / static_cast<double>(me.mask.total());
  if (patch.content < kMinContent) return nullptr;
  const bool whole = patch.content == 1;
  patch.spectrum = me.registrar.Analyze(me.grey, whole ? cv::Mat() : me.mask);
  if (!ratios.empty()) SetHeights(ratios, me.registrar, patch.spectrum);
  return std::make_shared<const Patch>(std::move(patch));
}

/// From the mosaic, as one plane.
void MapPatches::Impl::DrawPlane(const mosaic::ViewPlacement& placement,
                                 cv::Mat& to,
                                 cv::Mat& content) const {
  const store::MosaicGrid& grid = map.Grid();
  const cv::Size size = view.Size();
  to.create(size, CV_8UC1);
  content.create(size, CV_8UC1);
  // The window of the mosaic around the view, with room for the interpolation.
  constexpr double kMarginPx = 4;
  const cv::Rect window = WindowOf(placement.Bounds(), kMarginPx * grid.resolution);
  if (window.empty()) {
    content.setTo(0);
    return;
  }
  cv::Mat seen;
  cv::Mat alpha;
  map.ReadMosaic(window, seen, alpha);
  if (other_light) DrawLooks(window, seen);
  // For a camera of lower resolution, means of the map's pixels are used.
  const int factor =
      std::max(1, static_cast<int>(std::lround(view.MetresPerPixel() / grid.resolution)));
  if (factor > 1) {
    const cv::Size reduced((window.width + factor - 1) / factor,
                           (window.height + factor - 1) / factor);
    const int right = reduced.width * factor - window.width;
    const int bottom = reduced.height * factor - window.height;
    cv::copyMakeBorder(seen, seen, 0, bottom, 0, right, cv::BORDER_REPLICATE);
    cv::copyMakeBorder(alpha, alpha, 0, bottom, 0, right, cv::BORDER_CONSTANT, cv::Scalar(0));
    cv::resize(seen, seen, reduced, 0, 0, cv::INTER_AREA);
    cv::resize(alpha, alpha, reduced, 0, 0, cv::INTER_AREA);
  }
  const auto in_window = [&](const cv::Point2d& p) {
    const double along = (p.x - grid.min_x) / grid.resolution - 0.5 - window.x;
    const double down = (grid.max_y - p.y) / grid.resolution - 0.5 - window.y;
    return cv::Point2d((along + 0.5) / factor - 0.5, (down + 0.5) / factor - 0.5);
  };
  // An affine mapping, given by three points.
  const cv::Point2d origin = in_window(placement.ToMap(0, 0));
  const cv::Point2d along_u = in_window(placement.ToMap(1, 0)) - origin;
  const cv::Point2d along_v = in_window(placement.ToMap(0, 1)) - origin;
  const cv::Matx23d affine(along_u.x, along_v.x, origin.x, along_u.y, along_v.y, origin.y);
  const int warp = cv::WARP_INVERSE_MAP;
  cv::warpAffine(seen, to, affine, size, cv::INTER_CUBIC | warp, cv::BORDER_REPLICATE);
  cv::warpAffine(
      alpha, content, affine, size, cv::INTER_LINEAR | warp, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::threshold(content, content, 254, 255, cv::THRESH_BINARY);
}

cv::Mat MapPatches::Draw(const Pose2& T_map_base, cv::Mat& grey, cv::Mat& mask) const {
  Impl& me = *impl_;
  const mosaic::ViewPlacement placement = me.PlacementAt(T_map_base);
  cv::Mat ratios;
  if (me.depth != nullptr && me.depth->HasDepth()) {
    ratios = me.depth->Ratios(placement);
    me.keyframes.Draw(
        placement, me.view.MetresPerPixel(), me.depth->SurfaceOf(placement, ratios), grey, mask);
  } else {
    me.DrawPlane(placement, grey, mask);
  }
  // The interpolation reaches two pixels beyond an edge.
  cv::erode(mask, mask, cv::Mat(), {-1, -1}, 2, cv::BORDER_CONSTANT, cv::Scalar(255));
  grey.setTo(0, mask == 0);  // black is ignored by the noise estimate
  return ratios;
}

}  // namespace ceilmap::localization
