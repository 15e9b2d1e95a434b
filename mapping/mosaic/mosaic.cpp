#include "mapping/mosaic/mosaic.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <thread>
#include <unordered_map>

#include "calib/base/error.hpp"
#include "calib/base/parallel.hpp"
#include "calib/level_view.hpp"
#include "mapping/mosaic/exposure.hpp"
#include "mapping/mosaic/exposure_sampling.hpp"
#include "mapping/mosaic/image_cache.hpp"
#include "mapping/mosaic/levelling.hpp"
#include "mapping/mosaic/padded_image.hpp"
#include "mapping/mosaic/row_times.hpp"
#include "mapping/mosaic/sharpness.hpp"
#include "mapping/mosaic/tile_rows.hpp"
#include "mapping/mosaic/view_agreement.hpp"
#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_metadata.hpp"

namespace ceilmap::mosaic {
namespace {

// Feathering: an image's weight falls from its centre to its border as (distance to the
// border)^power. 1 is a plain linear feather; larger values take each point of the ceiling
// almost entirely from the image in which it is most central, which avoids doubled edges from
// small errors of the poses and of the heights.
constexpr double kFeatherPower = 4;

/// Side of the part of the mosaic that one thread renders at a time.
constexpr int kTilePx = 256;
/// An image is ignored at a point where its weight is below this fraction of the largest one: it
/// would change the grey value by less than half a level, but costs as much as the others.
constexpr float kNegligible = 0.02F;

std::int64_t TileKey(int tile_x, int tile_y) {
  return std::int64_t{tile_y} * (std::int64_t{1} << 32) + tile_x;
}

}  // namespace

void MosaicParams::Validate() const {
  const auto fail = [](const std::string& what) { throw InputError("mosaic." + what); };
  if (!std::isfinite(resolution) || resolution < 0) {
    fail("resolution = " + std::to_string(resolution) + ", must be >= 0");
  }
  if (!(sharpness_power >= 0 && sharpness_power <= 64)) {
    fail("sharpness_power = " + std::to_string(sharpness_power) + ", must be in [0, 64]");
  }
  if (cache_images < 1) {
    fail("cache_images = " + std::to_string(cache_images) + ", must be >= 1");
  }
  if (threads < 0) fail("threads = " + std::to_string(threads) + ", must be >= 0");
  if (!view_mask.empty() && view_mask.type() != CV_8UC1) fail("view_mask must be CV_8UC1");
}

struct MosaicRenderer::Impl {
  Impl(const std::vector<graph::Keyframe>& keyframes,
       const store::MapMetadata& metadata,
       graph::ImageLoader loader,
       const MosaicParams& mosaic_params);

  cv::Mat LoadImage(std::int64_t id) const;
  void MakeGrid();
  void MakeIndex();
  void Survey();
  void WeighBySharpness(const std::vector<double>& sharpness);
  std::vector<int> ViewsAt(const cv::Rect& tile) const;
  bool HasBlanks(const cv::Mat& image) const;
  template <typename Visit>
  void ForEachPixel(int k,
                    const Agreement& agreement,
                    const cv::Rect& tile,
                    const TileRatios& ratios,
                    const Visit& visit) const;
  void RenderTile(const cv::Rect& tile, cv::Mat grey, cv::Mat alpha) const;

  MosaicParams params;
  cv::Size view_size;
  double units_per_px;
  graph::ImageLoader load;
  std::vector<std::int64_t> ids;
  std::vector<ViewPlacement> views;
  HeightMap heights;
  cv::Mat row_times;  // of a rolling shutter; else empty
  ExposureModel exposure;
  CeilingExtent ceiling;
  std::vector<float> gain_factors;  // 1 / exp(g_k)
  std::vector<float> view_weights;  // below 1 for blurred images
  std::vector<bool> has_blanks;     // true for images of a tilted robot
  cv::Mat shading;                  // Shading of each image pixel
  Thumbnails thumbnails;
  store::MosaicGrid grid;
  std::unordered_map<std::int64_t, std::vector<int>> index;  // tile -> views that may touch it
  mutable ImageCache cache;                                  // padded images
};

MosaicRenderer::Impl::Impl(const std::vector<graph::Keyframe>& keyframes,
                           const store::MapMetadata& metadata,
                           graph::ImageLoader loader,
                           const MosaicParams& mosaic_params)
    : params(mosaic_params),
      view_size(metadata.view_size),
      units_per_px(metadata.view_units_per_px),
      load(std::move(loader)),
      views(PlaceViews(keyframes, metadata)),
      heights(keyframes, metadata, mosaic_params.threads),
      row_times(RowTimes(metadata)),
      ceiling(keyframes, metadata, heights),
      thumbnails(metadata.view_size),
      cache([this](std::int64_t id) { return LoadImage(id); }, mosaic_params.cache_images) {
  for (const graph::Keyframe& keyframe : keyframes) ids.push_back(keyframe.id);
  if (params.threads == 0) params.threads = static_cast<int>(std::thread::hardware_concurrency());
  params.threads = std::max(params.threads, 1);
  MakeGrid();
  MakeIndex();
  Survey();
  if (params.reject_outliers && !heights.empty()) {
    const auto agreement = [this](const cv::Point2d& p_map, float rho) {
      const cv::Point at(cvFloor((p_map.x - grid.min_x) / grid.resolution),
                         cvFloor((grid.max_y - p_map.y) / grid.resolution));
      if (at.x < 0 || at.y < 0) return 1.0;
      return AgreementAt(p_map, rho, views, ViewsAt({at, cv::Size(1, 1)}), thumbnails);
    };
    ceiling.AddMoving(heights.Settle(keyframes, metadata, agreement, params.threads),
                      heights.Grid().resolution);
  }
}

/// The single pass over all images before rendering: exposure, sharpness, thumbnails.
void MosaicRenderer::Impl::Survey() {
  exposure.log_gain.assign(views.size(), 0);
  std::vector<double> sharpness(views.size(), 0);
  has_blanks.assign(views.size(), false);
  const auto image = [this, &sharpness](std::size_t k) {
    const ImageCache::Image padded = cache.Get(ids[k]);
    cv::Mat inner = (*padded)(cv::Rect(kPadding, kPadding, view_size.width, view_size.height));
    has_blanks[k] = HasBlanks(inner);
    if (params.reject_outliers) thumbnails.Add(inner);
    if (params.sharpness_power > 0) sharpness[k] = Sharpness(inner);
    return inner;
  };
  if (params.level_exposure) {
    exposure =
        SolveExposure(static_cast<int>(views.size()),
                      ObserveExposure(views, view_size, units_per_px, heights, row_times, image),
                      !row_times.empty());
  } else {
    for (std::size_t k = 0; k < views.size(); ++k) image(k);
  }
  for (const double gain : exposure.log_gain) {
    gain_factors.push_back(static_cast<float>(std::exp(-gain)));
  }
  shading = MakeShading(view_size, params.view_mask, kFeatherPower, exposure);
  if (params.reject_outliers) thumbnails.Level(gain_factors, shading);
  WeighBySharpness(sharpness);
}

/// Whether an image has pixels without content in addition to those that no image has content for.
bool MosaicRenderer::Impl::HasBlanks(const cv::Mat& image) const {
  const cv::Mat content = calib::ContentMask(image);
  if (content.empty()) return false;
  return params.view_mask.empty() || cv::countNonZero(~content & params.view_mask) > 0;
}

/// Images are compared at the place of each image's centre, which the image shows best.
void MosaicRenderer::Impl::WeighBySharpness(const std::vector<double>& sharpness) {
  constexpr double kMin = 1e-4;  // keeps places that no other image shows
  for (std::size_t k = 0; k < views.size(); ++k) {
    const cv::Point2d centre = views[k].Centre();
    const cv::Rect at(static_cast<int>((centre.x - grid.min_x) / grid.resolution),
                      static_cast<int>((grid.max_y - centre.y) / grid.resolution),
                      1,
                      1);
    double sharpest = sharpness[k];
    for (const int other : ViewsAt(at)) sharpest = std::max(sharpest, sharpness[other]);
    const double sharpness_ratio = sharpest > 0 ? sharpness[k] / sharpest : 1;
    view_weights.push_back(
        static_cast<float>(std::max(kMin, std::pow(sharpness_ratio, params.sharpness_power))));
  }
}

/// An image ready for sampling: smoothed when the mosaic is coarser, then padded.
cv::Mat MosaicRenderer::Impl::LoadImage(std::int64_t id) const {
  cv::Mat image = load(id);
  if (image.type() != CV_8UC1 || image.size() != view_size) {
    throw RunError("the image of keyframe " + std::to_string(id) +
                   " is missing or not of the view's size");
  }
  const double reduction = grid.resolution / units_per_px;
  cv::Mat padded;
  if (reduction > 1.2) {
    cv::GaussianBlur(image, padded, {}, 0.5 * std::sqrt(reduction * reduction - 1));
    image = padded;
    padded = cv::Mat();
  }
  cv::copyMakeBorder(image, padded, kPadding, kPadding, kPadding, kPadding, cv::BORDER_REPLICATE);
  return padded;
}

namespace {

store::MosaicGrid GridOver(const cv::Rect2d& box, double resolution) {
  // Bounds that are a multiple of the resolution up to rounding must not add an empty row.
  constexpr double kSlack = 1e-6;
  constexpr double kMaxPixels = 1e9;  // per row; larger counts are limited to this value
  const double left = std::floor(box.x / resolution + kSlack);
  const double right = std::ceil(box.br().x / resolution - kSlack);
  const double bottom = std::floor(box.y / resolution + kSlack);
  const double top = std::ceil(box.br().y / resolution - kSlack);
  store::MosaicGrid grid;
  grid.resolution = resolution;
  grid.min_x = left * resolution;
  grid.max_y = top * resolution;
  grid.width_px = static_cast<int>(std::min(right - left, kMaxPixels));
  grid.height_px = static_cast<int>(std::min(top - bottom, kMaxPixels));
  return grid;
}

}  // namespace

/// Coarsens the mosaic until it can be stored: a failure to store it would lose the whole map after
/// hours of driving.
void MosaicRenderer::Impl::MakeGrid() {
  cv::Rect2d box = views.front().Bounds();
  for (const ViewPlacement& view : views) box |= view.Bounds();
  if (!ceiling.empty()) box &= ceiling.Bounds();
  constexpr int kMaxSteps = 40;  // a factor of 1e12: then the cause is not the resolution
  double resolution = params.resolution > 0 ? params.resolution : units_per_px;
  for (int step = 0; step < kMaxSteps; ++step) {
    grid = GridOver(box, resolution);
    if (store::Problem(grid).empty()) return;
    resolution *= 2;
  }
  throw RunError("the keyframes' poses are no usable numbers");
}

void MosaicRenderer::Impl::MakeIndex() {
  for (std::size_t k = 0; k < views.size(); ++k) {
    cv::Rect2d box = views[k].Bounds();
    if (!heights.empty()) {
      box |= views[k].Bounds(heights.Range()[0]);
      box |= views[k].Bounds(heights.Range()[1]);
    }
    const auto tile_of = [&](double units) {
      return std::max(static_cast<int>(units / grid.resolution) / kTilePx, 0);
    };
    for (int y = tile_of(grid.max_y - box.br().y); y <= tile_of(grid.max_y - box.y); ++y) {
      for (int x = tile_of(box.x - grid.min_x); x <= tile_of(box.br().x - grid.min_x); ++x) {
        index[TileKey(x, y)].push_back(static_cast<int>(k));
      }
    }
  }
}

/// @param tile  inside one tile of the index.
std::vector<int> MosaicRenderer::Impl::ViewsAt(const cv::Rect& tile) const {
  const auto found = index.find(TileKey(tile.x / kTilePx, tile.y / kTilePx));
  return found == index.end() ? std::vector<int>() : found->second;
}

/// Calls visit(position in the tile, image pixel, weight, vignetting factor) for each pixel of
/// the tile that lies inside the image.
template <typename Visit>
void MosaicRenderer::Impl::ForEachPixel(int k,
                                        const Agreement& agreement,
                                        const cv::Rect& tile,
                                        const TileRatios& ratios,
                                        const Visit& visit) const {
  const ViewPlacement& view = views[k];
  ImageCache::Image blanks;
  if (has_blanks[k]) blanks = cache.Get(ids[k]);
  const double max_u = view_size.width - 1;
  const double max_v = view_size.height - 1;
  for (int row = 0; row < tile.height; ++row) {
    const RowMap map = MapRow(view, view_size, grid, tile, row, ratios);
    const float* row_ratios = ratios.rho.empty() ? nullptr : ratios.rho.ptr<float>(row) - tile.x;
    for (int col = map.first; col < map.last; ++col) {
      cv::Point2d pixel = map.start + col * map.step;
      if (row_ratios != nullptr) {
        pixel = view.Principal() + row_ratios[col] * (pixel - view.Principal());
        if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x <= max_u && pixel.y <= max_v)) continue;
      }
      pixel = {std::clamp(pixel.x, 0.0, max_u), std::clamp(pixel.y, 0.0, max_v)};
      if (blanks && TouchesBlank(*blanks, pixel)) continue;
      // Weight and vignetting are smooth: the values of the nearest pixel suffice.
      const Shading& shade = shading.ptr<Shading>(cvRound(pixel.y))[cvRound(pixel.x)];
      const float agreed = agreement.IsFull() ? 1 : agreement.At(col, tile.y + row);
      visit(cv::Point(col - tile.x, row), pixel, shade[0] * agreed, shade[1]);
    }
  }
}

void MosaicRenderer::Impl::RenderTile(const cv::Rect& tile, cv::Mat grey, cv::Mat alpha) const {
  const cv::Mat inside = ceiling.Over(tile, grid);
  if (!inside.empty() && cv::countNonZero(inside) == 0) {
    grey.setTo(0);
    alpha.setTo(0);
    return;
  }
  const std::vector<int> candidates = ViewsAt(tile);
  std::vector<Agreement> agreements(candidates.size());
  if (params.reject_outliers) {
    agreements = CompareViews(tile, grid, views, candidates, thumbnails, heights);
  }
  const TileRatios ratios(heights.RatiosOver(tile, grid));
  cv::Mat largest(tile.size(), CV_32FC1, cv::Scalar(0));
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const float share = view_weights[candidates[i]];
    ForEachPixel(candidates[i],
                 agreements[i],
                 tile,
                 ratios,
                 [&](cv::Point at, cv::Point2d /*pixel*/, float weight, float /*vignetting*/) {
                   float& most = largest.ptr<float>(at.y)[at.x];
                   most = std::max(most, share * weight);
                 });
  }
  const auto band_factor = [this](int k, cv::Point2d pixel) {
    const float row_s = row_times.ptr<float>(cvRound(pixel.y))[cvRound(pixel.x)];
    return static_cast<float>(std::exp(-exposure.LogBand(k, row_s)));
  };
  cv::Mat sums(tile.size(), CV_32FC2, cv::Scalar(0, 0));  // of weight * grey, of weight
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const ImageCache::Image image = cache.Get(ids[candidates[i]]);
    const float gain = gain_factors[candidates[i]];
    const bool has_bands = !exposure.bands.empty() && exposure.bands[candidates[i]] != 0.0;
    const float share = view_weights[candidates[i]];
    ForEachPixel(candidates[i],
                 agreements[i],
                 tile,
                 ratios,
                 [&](cv::Point at, cv::Point2d pixel, float weight, float vignetting) {
                   weight *= share;
                   if (weight <= kNegligible * largest.ptr<float>(at.y)[at.x]) return;
                   if (has_bands) vignetting *= band_factor(candidates[i], pixel);
                   auto& sum = sums.ptr<cv::Vec2f>(at.y)[at.x];
                   sum[0] += weight * LevelGrey(Sample(*image, pixel), gain * vignetting);
                   sum[1] += weight;
                 });
  }
  for (int row = 0; row < tile.height; ++row) {
    for (int col = 0; col < tile.width; ++col) {
      const cv::Vec2f sum = sums.ptr<cv::Vec2f>(row)[col];
      const bool seen = sum[1] > 0 && (inside.empty() || inside.ptr<unsigned char>(row)[col] != 0);
      grey.ptr<unsigned char>(row)[col] =
          seen ? cv::saturate_cast<unsigned char>(sum[0] / sum[1]) : 0;
      alpha.ptr<unsigned char>(row)[col] = seen ? 255 : 0;
    }
  }
}

MosaicRenderer::MosaicRenderer(const std::vector<graph::Keyframe>& keyframes,
                               const store::MapMetadata& metadata,
                               graph::ImageLoader loader,
                               const MosaicParams& params) {
  params.Validate();
  if (const std::string problem = store::Problem(metadata); !problem.empty()) {
    throw InputError("cannot render a mosaic: " + problem);
  }
  if (keyframes.empty()) throw InputError("cannot render a mosaic of no keyframes");
  if (!params.view_mask.empty() && params.view_mask.size() != metadata.view_size) {
    throw InputError("mosaic.view_mask must be of the view's size");
  }
  impl_ = std::make_unique<Impl>(keyframes, metadata, std::move(loader), params);
}

MosaicRenderer::~MosaicRenderer() = default;

const store::MosaicGrid& MosaicRenderer::Grid() const {
  return impl_->grid;
}

const std::vector<store::LeftOut>& MosaicRenderer::LeftOutPlaces() const {
  return impl_->ceiling.LeftOutPlaces();
}

const HeightMap& MosaicRenderer::Heights() const {
  return impl_->heights;
}

void MosaicRenderer::Render(const cv::Rect& window, cv::Mat& grey, cv::Mat& alpha) const {
  const cv::Rect all(0, 0, impl_->grid.width_px, impl_->grid.height_px);
  if (window.empty() || (window & all) != window) {
    throw InputError("the window to render lies outside the mosaic");
  }
  grey.create(window.size(), CV_8UC1);
  alpha.create(window.size(), CV_8UC1);
  std::vector<cv::Rect> tiles;
  for (int y = window.y / kTilePx * kTilePx; y < window.br().y; y += kTilePx) {
    for (int x = window.x / kTilePx * kTilePx; x < window.br().x; x += kTilePx) {
      tiles.push_back(cv::Rect(x, y, kTilePx, kTilePx) & window);
    }
  }
  ParallelFor(static_cast<int>(tiles.size()), impl_->params.threads, [&](int i) {
    const cv::Rect inner = tiles[i] - window.tl();
    impl_->RenderTile(tiles[i], grey(inner), alpha(inner));
  });
}

}  // namespace ceilmap::mosaic
