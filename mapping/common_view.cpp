#include "mapping/common_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "calib/base/error.hpp"
#include "calib/level_view.hpp"
#include "calib/size_text.hpp"

namespace ceilmap::mapping {
namespace {

// At the border of an image this difference of scale causes an error of a few hundredths of a
// pixel.
constexpr double kSameScale = 1e-4;
// Smaller common views have too little texture for a registration, pixels.
constexpr int kMinCommonSide = 96;

bool IsSame(double a, double b) {
  return std::abs(a / b - 1) <= kSameScale;
}

/// Distance of the camera from the plane of the ceiling, map units; 0: not known.
double DistanceOf(const store::MapMetadata& metadata) {
  return metadata.view_focal_px * metadata.view_units_per_px;
}

/// Heights are relative to the camera's distance from the ceiling.
std::string DistanceProblem(const store::MapMetadata& a, const store::MapMetadata& b) {
  const double at_a = DistanceOf(a);
  const double at_b = DistanceOf(b);
  if (at_a == 0 || at_b == 0 || IsSame(at_a, at_b)) return {};
  return fmt::format(
      "their cameras are {:.6g} and {:.6g} {} below the ceiling, which is not one plane; use maps "
      "of cameras at one height",
      at_a,
      at_b,
      a.unit);
}

std::string SizeProblem(const store::MapMetadata& a, const store::MapMetadata& b) {
  if (a.view_size == b.view_size) return {};
  return fmt::format("their images have {}x{} and {}x{} px; use maps of one kind of camera",
                     a.view_size.width,
                     a.view_size.height,
                     b.view_size.width,
                     b.view_size.height);
}

cv::Point2d CentreOf(cv::Size size) {
  return {0.5 * (size.width - 1), 0.5 * (size.height - 1)};
}

/// Pixels of an image for pixels of a smaller one of the same plane, `ratio` times as coarse. The
/// centres of both show the same point.
cv::Matx23d FineFromCoarse(cv::Size fine, cv::Size coarse, double ratio) {
  const cv::Point2d offset = CentreOf(fine) - ratio * CentreOf(coarse);
  return {ratio, 0, offset.x, 0, ratio, offset.y};
}

/// Standard deviation of the smoothing before an image is drawn `ratio` times as coarse, pixels.
double SmoothingSigma(double ratio) {
  return ratio > 1 ? 0.5 * std::sqrt(ratio * ratio - 1) : 0;
}

/// Where a drawn image has content that no pixel without content influences.
cv::Mat DrawnContent(const cv::Mat& content, cv::Size size, double ratio) {
  constexpr double kSigmas = 2;
  const int reach = static_cast<int>(std::ceil(kSigmas * SmoothingSigma(ratio))) + 2;
  const cv::Mat kernel(2 * reach + 1, 2 * reach + 1, CV_8UC1, cv::Scalar(1));
  cv::Mat inner;
  cv::erode(content, inner, kernel);
  cv::Mat drawn;
  cv::warpAffine(inner,
                 drawn,
                 FineFromCoarse(content.size(), size, ratio),
                 size,
                 cv::INTER_NEAREST | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  return drawn;
}

cv::Mat DrawnImage(const cv::Mat& image, cv::Size size, double ratio) {
  cv::Mat smooth = image;
  if (const double sigma = SmoothingSigma(ratio); sigma > 0) {
    cv::GaussianBlur(image, smooth, {}, sigma, sigma, cv::BORDER_REPLICATE);
  }
  cv::Mat drawn;
  cv::warpAffine(smooth,
                 drawn,
                 FineFromCoarse(image.size(), size, ratio),
                 size,
                 cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  return drawn;
}

/// Size and scale of the common view, in `common`.
void FindExtent(const std::vector<NamedMap>& maps, store::MapMetadata& common) {
  double width = INFINITY;
  double height = INFINITY;
  for (const NamedMap& named : maps) {
    const store::MapMetadata& map = named.map->Metadata();
    common.view_units_per_px = std::max(common.view_units_per_px, map.view_units_per_px);
    width = std::min(width, map.view_size.width * map.view_units_per_px);
    height = std::min(height, map.view_size.height * map.view_units_per_px);
  }
  constexpr double kRounding = 0.1;  // maps of one kind of camera keep their size
  const auto pixels = [&common](double extent) {
    return static_cast<int>(std::floor(extent / common.view_units_per_px + kRounding));
  };
  common.view_size = {pixels(width), pixels(height)};
}

void CheckTogether(const std::vector<NamedMap>& maps) {
  const bool has_heights = std::any_of(
      maps.begin(), maps.end(), [](const NamedMap& named) { return named.map->HasHeights(); });
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const store::MapMetadata& a = maps[i].map->Metadata();
    for (std::size_t j = i + 1; j < maps.size(); ++j) {
      const store::MapMetadata& b = maps[j].map->Metadata();
      std::string problem;
      if (a.unit != "m" || b.unit != "m") problem = Incompatibility(a, b);
      if (problem.empty() && has_heights) problem = DistanceProblem(a, b);
      if (problem.empty()) continue;
      throw InputError(fmt::format("{} and {}: {}", maps[i].name, maps[j].name, problem));
    }
  }
}

/// Metadata of the common view, without its mask.
store::MapMetadata CommonMetadata(const std::vector<NamedMap>& maps) {
  CheckTogether(maps);
  const store::MapMetadata& reference = maps.front().map->Metadata();
  store::MapMetadata common = reference;
  common.view_mask.release();
  const bool differ = std::any_of(maps.begin(), maps.end(), [&](const NamedMap& named) {
    const store::MapMetadata& map = named.map->Metadata();
    return map.view_size != reference.view_size ||
           !IsSame(map.view_units_per_px, reference.view_units_per_px);
  });
  if (differ) FindExtent(maps, common);
  if (std::min(common.view_size.width, common.view_size.height) < kMinCommonSide && differ) {
    throw InputError(
        fmt::format("the cameras of the maps differ too much: the part of the ceiling that images "
                    "of all of them show has {} px at the coarsest scale, at least {}x{} are "
                    "needed; leave out the map with the smallest or the coarsest images",
                    calib::SizeText(common.view_size),
                    kMinCommonSide,
                    kMinCommonSide));
  }
  const double ratio = common.view_units_per_px / reference.view_units_per_px;
  common.view_focal_px /= ratio;
  common.view_principal_px /= ratio;
  // The mosaic has no more detail than the images.
  common.resolution *= std::max(1.0, ratio);
  return common;
}

/// What the images of all maps show; empty: everything.
cv::Mat CommonMask(const std::vector<NamedMap>& maps, const CommonView& view) {
  cv::Mat all;
  for (const NamedMap& named : maps) {
    const store::MapMetadata& map = named.map->Metadata();
    if (map.view_mask.empty()) continue;
    const cv::Mat mask =
        view.Keeps(map) ? map.view_mask
                        : DrawnContent(map.view_mask,
                                       view.Metadata().view_size,
                                       view.Metadata().view_units_per_px / map.view_units_per_px);
    all = all.empty() ? mask.clone() : cv::Mat(all & mask);
  }
  if (!all.empty() && cv::countNonZero(all) == all.size().area()) return {};
  return all;
}

}  // namespace

calib::CeilingView ViewOf(const store::MapMetadata& metadata) {
  return calib::CeilingView::OfRectified(
      metadata.view_size, metadata.view_units_per_px, metadata.T_base_view, metadata.view_mask);
}

std::string Incompatibility(const store::MapMetadata& a, const store::MapMetadata& b) {
  if (a.unit != b.unit) {
    return fmt::format("one map is in {}, the other in {}; make both with a rig", a.unit, b.unit);
  }
  if (std::string problem = SizeProblem(a, b); !problem.empty()) return problem;
  if (!IsSame(a.view_units_per_px, b.view_units_per_px)) {
    return fmt::format(
        "their images have {:.6g} and {:.6g} {} per px; use maps of one kind of "
        "camera at one height",
        a.view_units_per_px,
        b.view_units_per_px,
        a.unit);
  }
  // Heights are relative to the camera's distance from the ceiling.
  if (a.view_focal_px > 0 && b.view_focal_px > 0 && !IsSame(a.view_focal_px, b.view_focal_px)) {
    return fmt::format(
        "their cameras have focal lengths of {:.6g} and {:.6g} px; use maps of one kind of camera "
        "at one height",
        a.view_focal_px,
        b.view_focal_px);
  }
  return {};
}

CommonView::CommonView(const std::vector<NamedMap>& maps)
    : metadata_(CommonMetadata(maps)), view_(ViewOf(metadata_)) {
  metadata_.view_mask = CommonMask(maps, *this);
  view_ = ViewOf(metadata_);
}

bool CommonView::Keeps(const store::MapMetadata& from) const {
  return from.view_size == metadata_.view_size &&
         IsSame(from.view_units_per_px, metadata_.view_units_per_px);
}

cv::Mat CommonView::Resample(const cv::Mat& image, const store::MapMetadata& from) const {
  if (Keeps(from)) return image;
  const double ratio = metadata_.view_units_per_px / from.view_units_per_px;
  cv::Mat drawn = DrawnImage(image, metadata_.view_size, ratio);
  drawn = cv::max(drawn, 1);  // 0 means no content
  if (const cv::Mat content = calib::ContentMask(image); !content.empty()) {
    drawn.setTo(0, ~DrawnContent(content, drawn.size(), ratio));
  }
  if (!metadata_.view_mask.empty()) drawn.setTo(0, ~metadata_.view_mask);
  return drawn;
}

heights::HeightField CommonView::Resample(const heights::HeightField& heights,
                                          const store::MapMetadata& from) const {
  heights::HeightField drawn = heights;
  if (Keeps(from)) return drawn;
  const double ratio = metadata_.view_units_per_px / from.view_units_per_px;
  drawn.first_px /= ratio;
  drawn.step_px /= ratio;
  return drawn;
}

}  // namespace ceilmap::mapping
