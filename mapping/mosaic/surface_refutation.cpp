#include "mapping/mosaic/surface_refutation.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <opencv2/imgproc.hpp>

#include "mapping/mosaic/view_placement.hpp"

namespace ceilmap::mosaic {
namespace {

constexpr int kRefutedReach = 16;  // widest gap of refuted surfaces, pixels from its border
/// A surface is refuted if fewer of the images of the place confirm it, and there are so many.
constexpr double kFewConfirm = 0.15;
constexpr int kManyImages = 8;
constexpr float kRefutedAround = 0.3F;  // part of the neighbours
constexpr double kAgree = 0.75;         // part of the images that agree on a surface

/// The ratio of a known surface near a cell: of several the farther one, because a gap is what the
/// nearer one hides from most images. 0: there is none.
float FartherNear(const cv::Mat& rho, const cv::Point& cell, int reach, std::vector<float>& known) {
  constexpr double kFarther = 0.2;  // quantile
  known.clear();
  for (int row = cell.y - reach; row <= cell.y + reach; ++row) {
    const auto* values = rho.ptr<float>(row);
    for (int col = cell.x - reach; col <= cell.x + reach; ++col) {
      if (values[col] > 0) known.push_back(values[col]);
    }
  }
  if (known.empty()) return 0;
  const auto farther =
      known.begin() + static_cast<std::ptrdiff_t>(kFarther * static_cast<double>(known.size()));
  std::nth_element(known.begin(), farther, known.end());
  return *farther;
}

/// Whether a measured cell of a field, or one beside it, has a ratio: a border may lie between
/// them.
bool Confirms(const heights::HeightField& field, std::size_t cell, float rho) {
  const auto width = static_cast<std::size_t>(field.grid.width);
  const std::size_t col = cell % width;
  const std::size_t row = cell / width;
  const std::size_t last_row = std::min<std::size_t>(row + 1, field.grid.height - 1);
  for (std::size_t v = row - (row > 0 ? 1 : 0); v <= last_row; ++v) {
    for (std::size_t u = col - (col > 0 ? 1 : 0); u <= std::min(col + 1, width - 1); ++u) {
      const heights::HeightCell& at = field.cells[v * width + u];
      if (at.sigma < heights::kMeasuredSigma && std::abs(at.rho - rho) < kNearer * rho) return true;
    }
  }
  return false;
}

/// What the height fields of keyframes say about the surface of a pixel.
struct Witnesses {
  int images = 0;       // that show the place
  int confirm = 0;      // those that measured its surface there
  int see_through = 0;  // those that measured something behind it
};

/// The keyframes whose height fields judge the surfaces of a raster.
class Witnessing {
 public:
  Witnessing(const RatioRaster& raster,
             const std::vector<graph::Keyframe>& keyframes,
             const store::MapMetadata& metadata)
      : raster_(raster),
        keyframes_(keyframes),
        views_(PlaceViews(keyframes, metadata)),
        centre_((metadata.view_size.width - 1) / 2.0, (metadata.view_size.height - 1) / 2.0) {
    const cv::Vec2f range = raster.Range();
    bounds_.reserve(views_.size());
    for (const ViewPlacement& view : views_) {
      bounds_.push_back(view.Bounds(range[0]) | view.Bounds(range[1]));
    }
  }

  /// Of each pixel of a window with a known surface, row by row. @param ratios  of the window.
  [[nodiscard]] std::vector<Witnesses> Of(const cv::Rect& window,
                                          const cv::Mat_<float>& ratios) const {
    const cv::Rect2d box = raster_.BoxOf(window);
    std::vector<Witnesses> result(static_cast<std::size_t>(window.area()));
    for (std::size_t k = 0; k < views_.size(); ++k) {
      if (!keyframes_[k].heights || (bounds_[k] & box).empty()) continue;
      for (int row = 0; row < window.height; ++row) {
        for (int col = 0; col < window.width; ++col) {
          const float rho = ratios(row, col);
          if (rho <= 0) continue;
          const cv::Point2d place = raster_.PlaceOf(window.x + col, window.y + row);
          const int at = row * window.width + col;
          Count(k, place, rho, result[static_cast<std::size_t>(at)]);
        }
      }
    }
    return result;
  }

 private:
  void Count(std::size_t k, const cv::Point2d& place, float rho, Witnesses& witnesses) const {
    const heights::HeightField& field = *keyframes_[k].heights;
    const cv::Point2d at = views_[k].ToPixel(place.x, place.y, rho) - centre_;
    const auto cell = field.CellAt({at.x, at.y});
    if (!cell) return;
    ++witnesses.images;
    if (Confirms(field, *cell, rho)) {
      ++witnesses.confirm;
    } else if (field.cells[*cell].sigma < heights::kMeasuredSigma &&
               field.cells[*cell].rho < rho * (1 - kNearer)) {
      ++witnesses.see_through;
    }
  }

  const RatioRaster& raster_;
  const std::vector<graph::Keyframe>& keyframes_;
  std::vector<ViewPlacement> views_;
  std::vector<cv::Rect2d> bounds_;
  cv::Point2d centre_;
};

/// Refutes surfaces that few keyframes confirm and on which the images do not agree.
RatioRaster RefuteUnconfirmed(const RatioRaster& raster,
                              const Witnessing& witnessing,
                              const ImageAgreement& agreement,
                              int threads) {
  return raster.Transformed(threads, [&](const cv::Rect& window, const cv::Mat_<float>& ratios) {
    const std::vector<Witnesses> witnesses = witnessing.Of(window, ratios);
    cv::Mat_<float> result = ratios.clone();
    for (int row = 0; row < window.height; ++row) {
      for (int col = 0; col < window.width; ++col) {
        const int at = row * window.width + col;
        const Witnesses& here = witnesses[static_cast<std::size_t>(at)];
        if (here.images < kManyImages || here.confirm >= kFewConfirm * here.images) continue;
        float& rho = result(row, col);
        if (agreement(raster.PlaceOf(window.x + col, window.y + row), rho) < kAgree) rho = -rho;
      }
    }
    return result;
  });
}

/// Refutes surfaces among refuted ones on which the images do not agree.
RatioRaster RefuteAround(const RatioRaster& raster, const ImageAgreement& agreement, int threads) {
  constexpr int kReach = kFillReach;
  return raster.Transformed(threads, [&](const cv::Rect& window, const cv::Mat_<float>& ratios) {
    const cv::Rect wide(window.x - kReach,
                        window.y - kReach,
                        window.width + 2 * kReach,
                        window.height + 2 * kReach);
    cv::Mat refuted = raster.Ratios(wide);
    for (float& rho : cv::Mat_<float>(refuted)) rho = rho < 0 ? 1.0F : 0.0F;
    cv::Mat parts;
    cv::boxFilter(refuted, parts, -1, {2 * kReach + 1, 2 * kReach + 1});
    cv::Mat_<float> result = ratios.clone();
    for (int row = 0; row < window.height; ++row) {
      for (int col = 0; col < window.width; ++col) {
        float& rho = result(row, col);
        if (rho <= 0 || parts.at<float>(row + kReach, col + kReach) < kRefutedAround) continue;
        if (agreement(raster.PlaceOf(window.x + col, window.y + row), rho) < kAgree) rho = -rho;
      }
    }
    return result;
  });
}

/// Whether the images of a place agree on any surface. @param range  of its ratio.
bool IsExplained(const cv::Point2d& place,
                 const cv::Vec2f& range,
                 const ImageAgreement& agreement) {
  float rho = range[0];
  while (rho <= range[1] && agreement(place, rho) < kAgree) rho *= 1 + kSameSurface;
  return rho <= range[1];
}

/// Fills what is refuted: where no surface explains the images, or the images agree at least as
/// well on the result.
/// @param before  without refuted surfaces.
SettledSurfaces ReplaceRefuted(const RatioRaster& before,
                               const RatioRaster& refuted,
                               const ImageAgreement& agreement,
                               int threads) {
  const cv::Vec2f range = before.Range();
  const RatioRaster filled = FillGaps(refuted, threads);
  SettledSurfaces result;
  std::mutex mutex;
  result.raster =
      before.Transformed(threads, [&](const cv::Rect& window, const cv::Mat_<float>& old) {
        const cv::Mat_<float> flags = refuted.Ratios(window);
        const cv::Mat_<float> fillings = filled.Ratios(window);
        cv::Mat_<float> ratios = old.clone();
        for (int row = 0; row < window.height; ++row) {
          for (int col = 0; col < window.width; ++col) {
            if (flags(row, col) >= 0) continue;
            const cv::Point2d place = before.PlaceOf(window.x + col, window.y + row);
            const float filling = fillings(row, col);
            if (!IsExplained(place, range, agreement)) {
              ratios(row, col) = filling;
              const std::lock_guard lock(mutex);
              result.moving.push_back(place);
            } else if (!(agreement(place, filling) < agreement(place, old(row, col)))) {
              ratios(row, col) = filling;
            }
          }
        }
        return ratios;
      });
  return result;
}

}  // namespace

RatioRaster FillGaps(const RatioRaster& raster, int threads) {
  return raster.Transformed(threads, [&](const cv::Rect& window, const cv::Mat_<float>& ratios) {
    const cv::Mat wide = raster.Ratios({window.x - kRefutedReach,
                                        window.y - kRefutedReach,
                                        window.width + 2 * kRefutedReach,
                                        window.height + 2 * kRefutedReach});
    cv::Mat_<float> result = ratios.clone();
    std::vector<float> known;
    for (int row = 0; row < window.height; ++row) {
      for (int col = 0; col < window.width; ++col) {
        float& rho = result(row, col);
        if (rho > 0) continue;
        const cv::Point at(col + kRefutedReach, row + kRefutedReach);
        const float filled = FartherNear(wide, at, rho < 0 ? kRefutedReach : kFillReach, known);
        rho = filled > 0 ? filled : std::abs(rho);
      }
    }
    return result;
  });
}

RatioRaster ReplaceSeenThrough(const RatioRaster& raster,
                               const std::vector<graph::Keyframe>& keyframes,
                               const store::MapMetadata& metadata,
                               int threads) {
  const Witnessing witnessing(raster, keyframes, metadata);
  const RatioRaster refuted =
      raster.Transformed(threads, [&](const cv::Rect& window, const cv::Mat_<float>& ratios) {
        const std::vector<Witnesses> witnesses = witnessing.Of(window, ratios);
        cv::Mat_<float> result(ratios.size());
        std::transform(ratios.begin(),
                       ratios.end(),
                       witnesses.begin(),
                       result.begin(),
                       [](float rho, const Witnesses& here) {
                         return here.see_through > here.confirm ? -rho : rho;
                       });
        return result;
      });
  return FillGaps(refuted, threads);
}

SettledSurfaces SettleSurfaces(const RatioRaster& raster,
                               const std::vector<graph::Keyframe>& keyframes,
                               const store::MapMetadata& metadata,
                               const ImageAgreement& agreement,
                               int threads) {
  const Witnessing witnessing(raster, keyframes, metadata);
  const RatioRaster unconfirmed = RefuteUnconfirmed(raster, witnessing, agreement, threads);
  const RatioRaster refuted = RefuteAround(unconfirmed, agreement, threads);
  return ReplaceRefuted(raster, refuted, agreement, threads);
}

}  // namespace ceilmap::mosaic
