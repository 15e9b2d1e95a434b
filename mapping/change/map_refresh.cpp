#include "mapping/change/map_refresh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "calib/base/parallel.hpp"
#include "calib/level_view.hpp"
#include "mapping/change/view_comparison.hpp"
#include "mapping/places/place_descriptor.hpp"

namespace ceilmap::change {
namespace {

constexpr int kTilePx = 256;
// Fresh pixels are blended with the old ones over this distance inside the border of the cells.
constexpr double kBlendPx = 4;

/// Fresh pixels over a part of the mosaic.
struct FreshPixels {
  cv::Mat grey;    ///< CV_8UC1
  cv::Mat weight;  ///< CV_32FC1: 0 where nothing is fresh, 1 inside of fresh cells
};

/// The fresh cells of a map, by rows of tiles.
class FreshLooks {
 public:
  FreshLooks(const ChangeEvidence& evidence, const std::vector<cv::Point>& cells) {
    for (const cv::Point& cell : cells) {
      const CellEvidence* known = evidence.At(cell);
      if (known == nullptr || known->looks.empty()) continue;
      looks_.try_emplace({cell.y, cell.x}, known->looks[0].Mean());
    }
  }

  [[nodiscard]] bool empty() const { return looks_.empty(); }

  /// The tiles of a mosaic that contain fresh cells, as windows.
  [[nodiscard]] std::vector<cv::Rect> Tiles(const store::MosaicGrid& grid) const {
    std::map<std::pair<int, int>, cv::Rect> tiles;
    for (const auto& [cell, look] : looks_) {
      const int x = cell.second * kCellPx / kTilePx * kTilePx;
      const int y = cell.first * kCellPx / kTilePx * kTilePx;
      tiles[{y, x}] =
          cv::Rect(x, y, kTilePx, kTilePx) & cv::Rect(0, 0, grid.width_px, grid.height_px);
    }
    std::vector<cv::Rect> windows;
    windows.reserve(tiles.size());
    for (const auto& [at, window] : tiles) windows.push_back(window);
    return windows;
  }

  /// @param window  of the mosaic. @return no weight where nothing is fresh.
  [[nodiscard]] FreshPixels Over(const cv::Rect& window) const {
    FreshPixels fresh;
    // Weights depend on the cells around the window.
    const int margin = kCellPx;
    const cv::Rect wide(window.x - margin,
                        window.y - margin,
                        window.width + 2 * margin,
                        window.height + 2 * margin);
    cv::Mat whole(wide.size(), CV_8UC1, cv::Scalar(0));
    cv::Mat mask(wide.size(), CV_8UC1, cv::Scalar(0));
    const int first_row = cvFloor(static_cast<double>(wide.y) / kCellPx);
    bool any = false;
    for (auto at = looks_.lower_bound({first_row, -1}); at != looks_.end(); ++at) {
      const auto& [cell, look] = *at;
      if (cell.first * kCellPx >= wide.br().y) break;
      const cv::Rect pixels = PixelsOf({cell.second, cell.first, 1, 1});
      const cv::Rect inside = pixels & wide;
      if (inside.empty()) continue;
      look(inside - pixels.tl()).copyTo(whole(inside - wide.tl()));
      mask(inside - wide.tl()).setTo(255);
      any = any || !(inside & window).empty();
    }
    if (!any) return fresh;
    // Looks have no pixels where an image had none.
    mask.setTo(0, whole == 0);
    cv::Mat distance;
    cv::distanceTransform(mask, distance, cv::DIST_L2, cv::DIST_MASK_3);
    distance = cv::min(distance / kBlendPx, 1.0);
    const cv::Rect inner = window - wide.tl();
    fresh.grey = whole(inner).clone();
    fresh.weight = distance(inner).clone();
    return fresh;
  }

 private:
  std::map<std::pair<int, int>, cv::Mat> looks_;  // by row and column
};

/// @param fresh, weight  CV_32FC1. @param image  0 where there is no content, which stays so.
void Blend(const cv::Mat& fresh, const cv::Mat& weight, cv::Mat& image) {
  for (int row = 0; row < image.rows; ++row) {
    const float* share = weight.ptr<float>(row);
    const float* grey = fresh.ptr<float>(row);
    unsigned char* to = image.ptr<unsigned char>(row);
    for (int col = 0; col < image.cols; ++col) {
      if (share[col] <= 0 || to[col] == 0) continue;
      const double mixed = share[col] * grey[col] + (1 - share[col]) * to[col];
      to[col] = static_cast<unsigned char>(std::clamp(cvRound(mixed), 1, 255));
    }
  }
}

/// Draws the fresh pixels into the image of one keyframe.
class KeyframeRefresher {
 public:
  KeyframeRefresher(const store::MapReader& map,
                    const FreshLooks& cells,
                    const mosaic::HeightMap& heights)
      : map_(map),
        cells_(cells),
        comparer_(map, heights),
        describer_(map.Metadata().view_size,
                   map.Metadata().view_units_per_px,
                   places::PlaceDescriptorParams::ForCamera(map.Metadata().view_size,
                                                            map.Metadata().view_units_per_px),
                   map.Metadata().view_mask) {}

  /// False when the keyframe shows nothing fresh.
  bool Refresh(const graph::Keyframe& keyframe,
               const mosaic::ViewPlacement& placement,
               cv::Mat& image,
               cv::Mat& descriptors) {
    const store::MosaicGrid& grid = map_.Grid();
    const cv::Rect window = WindowOf(placement.Bounds(), grid);
    if (window.empty()) return false;
    const FreshPixels fresh = cells_.Over(window);
    if (fresh.weight.empty()) return false;
    image = map_.ReadImage(keyframe.id);
    const BrightnessFit fit = comparer_.FitTo(
        {image, map_.Metadata().view_mask, placement, map_.Metadata().view_units_per_px});
    // Gain over the window, then everything as the keyframe sees it.
    cv::Mat grey;
    fresh.grey.convertTo(grey, CV_32F);
    for (int row = 0; row < grey.rows; row += kStep) {
      for (int col = 0; col < grey.cols; col += kStep) {
        const cv::Rect part = cv::Rect(col, row, kStep, kStep) & cv::Rect({}, grey.size());
        const double gain = std::exp(fit.LogRatio(
            {window.x + part.x + 0.5 * part.width, window.y + part.y + 0.5 * part.height}));
        grey(part) *= gain;
      }
    }
    const auto in_window = [&](double u, double v) {
      const cv::Point2d p = placement.ToMap(u, v);
      return cv::Point2d((p.x - grid.min_x) / grid.resolution - 0.5 - window.x,
                         (grid.max_y - p.y) / grid.resolution - 0.5 - window.y);
    };
    const cv::Point2d origin = in_window(0, 0);
    const cv::Point2d along_u = in_window(1, 0) - origin;
    const cv::Point2d along_v = in_window(0, 1) - origin;
    const cv::Matx23d affine(along_u.x, along_v.x, origin.x, along_u.y, along_v.y, origin.y);
    cv::Mat drawn;
    cv::Mat weight;
    const int warp = cv::WARP_INVERSE_MAP;
    cv::warpAffine(grey, drawn, affine, image.size(), cv::INTER_CUBIC | warp, cv::BORDER_REPLICATE);
    cv::warpAffine(fresh.weight,
                   weight,
                   affine,
                   image.size(),
                   cv::INTER_LINEAR | warp,
                   cv::BORDER_CONSTANT,
                   cv::Scalar(0));
    if (cv::countNonZero(weight > 0) == 0) return false;
    Blend(drawn, weight, image);
    // The borders of an image that was drawn level would be taken for features of the ceiling.
    const bool level = keyframe.pose.tilt.IsLevel();
    descriptors =
        describer_.Describe(level ? image : cv::Mat(image.size(), CV_8UC1, cv::Scalar(0)));
    return true;
  }

 private:
  static constexpr int kStep = kCellPx;

  static cv::Rect WindowOf(const cv::Rect2d& box, const store::MosaicGrid& grid) {
    constexpr int kMargin = 2;
    const cv::Rect window(cv::Point(cvFloor((box.x - grid.min_x) / grid.resolution) - kMargin,
                                    cvFloor((grid.max_y - box.br().y) / grid.resolution) - kMargin),
                          cv::Point(cvCeil((box.br().x - grid.min_x) / grid.resolution) + kMargin,
                                    cvCeil((grid.max_y - box.y) / grid.resolution) + kMargin));
    return window & cv::Rect(0, 0, grid.width_px, grid.height_px);
  }

  const store::MapReader& map_;
  const FreshLooks& cells_;
  ViewComparer comparer_;
  places::PlaceDescriber describer_;
};

int RefreshTiles(const FreshLooks& cells, store::MapRevision& revision) {
  const store::MapReader& map = revision.Map();
  int tiles = 0;
  for (const cv::Rect& tile : cells.Tiles(map.Grid())) {
    const FreshPixels fresh = cells.Over(tile);
    if (fresh.weight.empty()) continue;
    cv::Mat grey;
    cv::Mat alpha;
    map.ReadMosaic(tile, grey, alpha);
    cv::Mat pixels;
    fresh.grey.convertTo(pixels, CV_32F);
    Blend(pixels, fresh.weight, grey);
    revision.WriteMosaic(tile, grey, alpha);
    ++tiles;
  }
  return tiles;
}

}  // namespace

RefreshReport RefreshMap(const ChangeEvidence& evidence,
                         const std::vector<cv::Point>& cells,
                         const mosaic::HeightMap& heights,
                         store::MapRevision& revision,
                         int threads) {
  RefreshReport report;
  const FreshLooks fresh(evidence, cells);
  if (fresh.empty()) return report;
  report.tiles = RefreshTiles(fresh, revision);
  const store::MapReader& map = revision.Map();
  const std::vector<graph::Keyframe> keyframes = map.ReadKeyframes();
  const std::vector<mosaic::ViewPlacement> views = mosaic::PlaceViews(keyframes, map.Metadata());
  const int workers = ThreadsFor(threads);
  std::vector<KeyframeRefresher> refreshers;
  refreshers.reserve(static_cast<std::size_t>(workers));
  for (int i = 0; i < workers; ++i) refreshers.emplace_back(map, fresh, heights);
  // Written in their order, so that the bytes of the file do not depend on the threads.
  constexpr int kBatch = 16;  // images in memory, per thread
  const std::size_t step = refreshers.size() * kBatch;
  for (std::size_t first = 0; first < views.size(); first += step) {
    const std::size_t count = std::min(step, views.size() - first);
    std::vector<std::optional<store::MapRevision::NewImage>> renewed(count);
    ParallelFor(workers, workers, [&](int worker) {
      for (auto i = static_cast<std::size_t>(worker); i < count; i += refreshers.size()) {
        store::MapRevision::NewImage to;
        to.keyframe_id = keyframes[first + i].id;
        if (refreshers[static_cast<std::size_t>(worker)].Refresh(
                keyframes[first + i], views[first + i], to.image, to.descriptors)) {
          renewed[i] = std::move(to);
        }
      }
    });
    std::vector<store::MapRevision::NewImage> images;
    images.reserve(count);
    for (auto& to : renewed) {
      if (to) images.push_back(std::move(*to));
    }
    revision.ReplaceImages(images, workers);
    report.keyframes += static_cast<int>(images.size());
  }
  return report;
}

}  // namespace ceilmap::change
