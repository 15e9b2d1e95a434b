#include "mapping/change/view_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "calib/base/statistics.hpp"
#include "calib/level_view.hpp"
#include "mapping/registration/noise.hpp"

namespace ceilmap::change {
namespace {

constexpr double kSmoothingPx = 1;  // of both images
constexpr int kRimPx = 3;           // three standard deviations of the smoothing
// Of the variance of white noise, what is left after interpolation and smoothing.
constexpr double kNoiseLeft = 0.07;
constexpr double kRounding = 0.1;   // variance, grey levels squared
constexpr double kLit = 240;        // a cell that is as bright as this shows a lit lamp
constexpr double kUnlit = 220;      // and one that is darker does not
constexpr int kMinLampPixels = 13;  // of the 256 of a cell
constexpr double kDark = 16;        // too dark to be levelled
// Heights in one cell that differ by more show the edge of something: cameras see it differently.
constexpr double kMaxRatioSpread = 0.03;

/// The cells around a view that lie on the mosaic.
cv::Rect CellsAround(const PlacedView& view, const store::MosaicGrid& grid, double rho) {
  const cv::Rect2d box = view.placement.Bounds(rho);
  const double cell = kCellPx * grid.resolution;
  const auto index = [](double value) {
    constexpr double kFarthest = 1e6;
    return static_cast<int>(std::clamp(std::floor(value), -1.0, kFarthest));
  };
  const cv::Rect cells(
      cv::Point(index((box.x - grid.min_x) / cell), index((grid.max_y - box.br().y) / cell)),
      cv::Point(index((box.br().x - grid.min_x) / cell) + 1,
                index((grid.max_y - box.y) / cell) + 1));
  return cells & CellsOf(grid);
}

/// Of the noise, grey levels squared.
double VarianceOf(const cv::Mat& image) {
  const double sigma = registration::EstimateNoise(image);
  return sigma * sigma;
}

}  // namespace

mosaic::HeightMap HeightsOf(const store::MapReader& map, int threads) {
  if (!map.HasHeights()) return {};
  return {map.ReadKeyframes(), map.Metadata(), threads};
}

ViewComparer::ViewComparer(const store::MapReader& map, const mosaic::HeightMap& heights)
    : map_(map), heights_(heights) {}

/// Draws the image over a window of the mosaic, and reads the map there.
void ViewComparer::Draw(const PlacedView& view, const cv::Rect& window) {
  const store::MosaicGrid& grid = map_.Grid();
  cv::Mat source = view.grey;
  const double reduction = grid.resolution / view.units_per_px;
  if (reduction > 1.2) {
    cv::GaussianBlur(
        view.grey, source, {}, 0.5 * std::sqrt(reduction * reduction - 1), 0, cv::BORDER_REPLICATE);
  }
  cv::Mat content = calib::ContentMask(view.grey);
  if (content.empty()) content = cv::Mat(view.grey.size(), CV_8UC1, cv::Scalar(255));
  if (!view.mask.empty()) content &= view.mask;
  const auto pixel_of = [&](double col, double row) {
    return view.placement.ToPixel(grid.min_x + (window.x + col + 0.5) * grid.resolution,
                                  grid.max_y - (window.y + row + 0.5) * grid.resolution);
  };
  const cv::Point2d origin = pixel_of(0, 0);
  const cv::Point2d across = pixel_of(1, 0) - origin;
  const cv::Point2d down = pixel_of(0, 1) - origin;
  const cv::Mat ratios = heights_.empty() ? cv::Mat() : heights_.RatiosOver(window, grid);
  const cv::Scalar none(0);
  if (ratios.empty()) {
    const cv::Matx23d affine(across.x, down.x, origin.x, across.y, down.y, origin.y);
    const int linear = cv::INTER_LINEAR | cv::WARP_INVERSE_MAP;
    cv::warpAffine(source, seen_, affine, window.size(), linear, cv::BORDER_CONSTANT, none);
    cv::warpAffine(content, valid_, affine, window.size(), linear, cv::BORDER_CONSTANT, none);
  } else {
    cv::Mat pixels(window.size(), CV_32FC2);
    const cv::Point2d principal = view.placement.Principal();
    for (int row = 0; row < window.height; ++row) {
      for (int col = 0; col < window.width; ++col) {
        const cv::Point2d plane = origin + col * across + row * down;
        const cv::Point2d at = principal + ratios.ptr<float>(row)[col] * (plane - principal);
        pixels.ptr<cv::Vec2f>(row)[col] = {static_cast<float>(at.x), static_cast<float>(at.y)};
      }
    }
    cv::remap(source, seen_, pixels, {}, cv::INTER_LINEAR, cv::BORDER_CONSTANT, none);
    cv::remap(content, valid_, pixels, {}, cv::INTER_LINEAR, cv::BORDER_CONSTANT, none);
  }
  cv::Mat alpha;
  map_.ReadMosaic(window, stored_, alpha);
  valid_ = (valid_ == 255) & (alpha == 255);
  // Smoothing mixes pixels at the border with what has no content.
  cv::erode(valid_, valid_, cv::Mat(), {-1, -1}, kRimPx, cv::BORDER_CONSTANT, none);
  if (ratios.empty()) return;
  // Edges of what hangs below the ceiling.
  cv::Mat low;
  cv::Mat high;
  const cv::Mat around(kCellPx / 2, kCellPx / 2, CV_8UC1, cv::Scalar(1));
  cv::erode(ratios, low, around);
  cv::dilate(ratios, high, around);
  valid_.setTo(0, high - low > kMaxRatioSpread);
}

bool ViewComparer::IsWhole(const cv::Rect& cell) const {
  return cv::countNonZero(valid_(cell)) == cell.area();
}

/// Makes the image as bright as the map.
void ViewComparer::LevelBy(const BrightnessFit& fit, const cv::Rect& window) {
  for (int row = 0; row < gains_.rows; ++row) {
    for (int col = 0; col < gains_.cols; ++col) {
      const cv::Point2d centre(window.x + (col + 0.5) * kCellPx, window.y + (row + 0.5) * kCellPx);
      gains_.ptr<float>(row)[col] = static_cast<float>(std::exp(fit.LogRatio(centre)));
    }
  }
  cv::Mat gains;
  cv::resize(gains_, gains, window.size(), 0, 0, cv::INTER_LINEAR);
  cv::divide(smooth_b_, gains, smooth_b_);
  cv::divide(seen_, gains, seen_, 1, CV_8U);
}

/// Noise of cells as it is: also of the codec, of interpolation and of small errors of the pose.
/// Most cells have not changed, and the plain half of them differs by noise only.
double ViewComparer::NoiseOf(const ViewComparison& result) const {
  const double expected = kNoiseLeft * (result.noise + VarianceOf(stored_)) + kRounding;
  std::vector<std::pair<double, double>> cells;  // signal, what differs
  for (const CellSums& sums : sums_) {
    if (sums.pixels == 0 || sums.MeanA() >= kUnlit || sums.MeanB() >= kUnlit) continue;
    const CellDifference difference = change::Compare(sums, 0);
    cells.emplace_back(difference.signal, difference.other);
  }
  constexpr std::size_t kMinCells = 20;
  if (cells.size() < kMinCells) return expected;
  const auto middle = cells.begin() + static_cast<std::ptrdiff_t>(cells.size() / 2);
  std::nth_element(cells.begin(), middle, cells.end());
  std::vector<double> others;
  others.reserve(cells.size() / 2);
  for (auto cell = cells.begin(); cell != middle; ++cell) others.push_back(cell->second);
  return std::max(expected, Median(others));
}

ViewComparer::LampPixels ViewComparer::LampsIn(const cv::Rect& cell, double gain) const {
  LampPixels lamp;
  if (cv::countNonZero(bright_(cell)) == 0) return lamp;
  const double overexposed = (kUnlit - 20) / gain;  // a surface that would look like a lamp
  for (int row = cell.y; row < cell.br().y; ++row) {
    const unsigned char* stored = lit_stored_.ptr(row);
    const unsigned char* seen = lit_seen_.ptr(row);
    const unsigned char* stored_around = around_stored_.ptr(row);
    const unsigned char* seen_around = around_seen_.ptr(row);
    for (int col = cell.x; col < cell.br().x; ++col) {
      if (stored[col] != 0 && seen[col] != 0) ++lamp.alike;
      if (stored[col] != 0 && seen_around[col] < kUnlit) ++lamp.differ;
      if (seen[col] != 0 && stored_around[col] < std::min(kUnlit, overexposed)) ++lamp.differ;
    }
  }
  return lamp;
}

/// @param at  in `result`.
void ViewComparer::Judge(const cv::Point& at, ViewComparison& result) const {
  const CellSums& sums = sums_[static_cast<std::size_t>(at.y * result.cells.width + at.x)];
  if (sums.pixels == 0) return;
  const double gain = gains_.ptr<float>(at.y)[at.x];
  const double as_taken = sums.MeanB() * gain;
  const bool stored_lit = sums.MeanA() >= kLit;
  CellState& state = result.states.ptr<CellState>(at.y)[at.x];
  const LampPixels lamp = LampsIn(PixelsOf({at.x, at.y, 1, 1}), gain);
  if (lamp.differ >= kMinLampPixels) {
    state = CellState::kLamp;
    ++result.lamps_differ;
    return;
  }
  if (lamp.alike >= kMinLampPixels) ++result.lamps_alike;
  if (stored_lit || as_taken >= kLit) {
    const bool both = stored_lit && (as_taken >= kLit || sums.MeanB() >= kLit);
    // A surface of the map that is so bright in this image that it looks like a lamp.
    const bool overexposed = !stored_lit && sums.MeanA() * gain > kUnlit - 20;
    const bool differs = stored_lit ? sums.MeanB() < kUnlit : sums.MeanA() < kUnlit;
    state = both                      ? CellState::kSame
            : overexposed || !differs ? CellState::kUnclear
                                      : CellState::kLamp;
    result.lamps_differ += state == CellState::kLamp ? 1 : 0;
    return;
  }
  // At the border of a lamp its glare differs, and what is dark cannot be levelled.
  const bool glare = cv::countNonZero(bright_(PixelsOf({at.x, at.y, 1, 1}))) > 0;
  if (glare || as_taken < kDark || sums.MeanA() < kDark) {
    state = CellState::kUnclear;
    return;
  }
  const CellDifference difference = change::Compare(sums, result.cell_noise);
  state = StateOf(difference, sums.MeanA(), result.cell_noise);
  result.differences.ptr<cv::Vec3f>(at.y)[at.x] = {static_cast<float>(difference.log_ratio),
                                                   static_cast<float>(difference.signal),
                                                   static_cast<float>(difference.other)};
}

/// How central each cell is in the image, 0..1.
cv::Mat ViewComparer::WeightsOf(const PlacedView& view, const cv::Rect& cells) const {
  const store::MosaicGrid& grid = map_.Grid();
  cv::Mat weights(cells.size(), CV_32FC1);
  const double half = 0.5 * std::min(view.grey.cols, view.grey.rows);
  for (int row = 0; row < cells.height; ++row) {
    for (int col = 0; col < cells.width; ++col) {
      const cv::Point2d at =
          view.placement.ToPixel(grid.min_x + (cells.x + col + 0.5) * kCellPx * grid.resolution,
                                 grid.max_y - (cells.y + row + 0.5) * kCellPx * grid.resolution);
      const double to_border = std::min(std::min(at.x, view.grey.cols - 1 - at.x),
                                        std::min(at.y, view.grey.rows - 1 - at.y));
      weights.ptr<float>(row)[col] = static_cast<float>(std::clamp(to_border / half, 0.0, 1.0));
    }
  }
  return weights;
}

/// The brightness of the image relative to the map, where no lamp is.
BrightnessFit ViewComparer::Fit(const cv::Rect& cells) const {
  std::vector<BrightnessFit::Sample> samples;
  samples.reserve(static_cast<std::size_t>(cells.area()));
  const cv::Rect window = PixelsOf(cells);
  for (int row = 0; row < cells.height; ++row) {
    for (int col = 0; col < cells.width; ++col) {
      const cv::Rect cell = PixelsOf({col, row, 1, 1});
      if (!IsWhole(cell)) continue;
      const double a = cv::mean(smooth_a_(cell))[0];
      const double b = cv::mean(smooth_b_(cell))[0];
      if (std::min(a, b) < kDark || std::max(a, b) >= kLit) continue;
      const cv::Point2d centre = 0.5 * cv::Point2d(cell.tl() + cell.br() + 2 * window.tl());
      samples.push_back({centre, std::log(b / a)});
    }
  }
  return {samples, window};
}

void ViewComparer::Smooth() {
  const auto smooth = [](const cv::Mat& image, cv::Mat& to) {
    image.convertTo(to, CV_32F);
    cv::GaussianBlur(to, to, {}, kSmoothingPx, kSmoothingPx, cv::BORDER_REPLICATE);
  };
  smooth(stored_, smooth_a_);
  smooth(seen_, smooth_b_);
}

BrightnessFit ViewComparer::FitTo(const PlacedView& view) {
  const cv::Rect cells = CellsAround(view, map_.Grid(), heights_.Range()[0]);
  if (cells.empty()) return {};
  Draw(view, PixelsOf(cells));
  Smooth();
  return Fit(cells);
}

ViewComparison ViewComparer::Compare(const PlacedView& view) {
  ViewComparison result;
  result.cells = CellsAround(view, map_.Grid(), heights_.Range()[0]);
  if (result.cells.empty()) return result;
  const cv::Rect window = PixelsOf(result.cells);
  Draw(view, window);
  constexpr double kSaturated = 248;
  lit_stored_ = stored_ >= kSaturated;
  lit_seen_ = seen_ >= kSaturated;
  bright_ = lit_stored_ | lit_seen_;
  constexpr int kMisplaced = 2;  // pixels, at most
  cv::dilate(stored_, around_stored_, cv::Mat(), {-1, -1}, kMisplaced);
  cv::dilate(seen_, around_seen_, cv::Mat(), {-1, -1}, kMisplaced);
  Smooth();
  gains_.create(result.cells.size(), CV_32FC1);
  result.fit = Fit(result.cells);
  LevelBy(result.fit, window);
  sums_.assign(static_cast<std::size_t>(result.cells.area()), {});
  for (int i = 0; i < result.cells.area(); ++i) {
    const cv::Rect cell = PixelsOf({i % result.cells.width, i / result.cells.width, 1, 1});
    if (!IsWhole(cell)) continue;
    sums_[static_cast<std::size_t>(i)] = SumsOver(smooth_a_(cell), smooth_b_(cell));
  }
  const double gain = cv::mean(gains_)[0];
  result.noise = VarianceOf(view.grey) / (gain * gain);
  result.cell_noise = NoiseOf(result);
  result.states = cv::Mat(result.cells.size(), CV_8UC1, cv::Scalar(0));
  result.differences = cv::Mat(result.cells.size(), CV_32FC3, cv::Scalar::all(0));
  for (int row = 0; row < result.cells.height; ++row) {
    for (int col = 0; col < result.cells.width; ++col) Judge({col, row}, result);
  }
  result.weights = WeightsOf(view, result.cells);
  seen_.setTo(0, valid_ == 0);
  result.levelled = seen_.clone();
  return result;
}

}  // namespace ceilmap::change
