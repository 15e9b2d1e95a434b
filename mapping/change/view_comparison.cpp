#include "mapping/change/view_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calib/level_view.hpp"
#include "mapping/registration/noise.hpp"

namespace ceilmap::change {
namespace {

constexpr double kSmoothingPx = 1;  // of both images
// Of the variance of white noise, what is left after interpolation and smoothing.
constexpr double kNoiseLeft = 0.07;
constexpr double kRounding = 0.1;  // variance, grey levels squared
constexpr double kLit = 240;       // a cell that is as bright as this shows a lit lamp
constexpr double kUnlit = 220;     // and one that is darker does not
constexpr double kDark = 16;       // too dark to be levelled
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

}  // namespace

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

/// @param cell  in the window. @param at  the same in `result`.
void ViewComparer::Judge(const cv::Rect& cell,
                         const cv::Point& at,
                         double noise,
                         ViewComparison& result) {
  if (!IsWhole(cell)) return;
  const CellSums sums = SumsOver(smooth_a_(cell), smooth_b_(cell));
  const double gain = gains_.ptr<float>(at.y)[at.x];
  const double as_taken = sums.MeanB() * gain;
  const bool stored_lit = sums.MeanA() >= kLit;
  CellState& state = result.states.ptr<CellState>(at.y)[at.x];
  float& share = result.differences.ptr<float>(at.y)[at.x];
  if (stored_lit || as_taken >= kLit) {
    const bool both = stored_lit && (as_taken >= kLit || sums.MeanB() >= kLit);
    // A surface of the map that is so bright in this image that it looks like a lamp.
    const bool overexposed = !stored_lit && sums.MeanA() * gain > kUnlit - 20;
    const bool differs = stored_lit ? sums.MeanB() < kUnlit : sums.MeanA() < kUnlit;
    state = both                      ? CellState::kSame
            : overexposed || !differs ? CellState::kUnclear
                                      : CellState::kLamp;
    result.lamps_alike += both ? 1 : 0;
    result.lamps_differ += state == CellState::kLamp ? 1 : 0;
    share = state == CellState::kLamp ? 1 : 0;
    return;
  }
  const CellDifference difference = change::Compare(sums, noise);
  state = as_taken < kDark || sums.MeanA() < kDark ? CellState::kUnclear : StateOf(difference);
  share = static_cast<float>(difference.share);
}

ViewComparison ViewComparer::Compare(const PlacedView& view) {
  const store::MosaicGrid& grid = map_.Grid();
  ViewComparison result;
  result.cells = CellsAround(view, grid, heights_.Range()[0]);
  if (result.cells.empty()) return result;
  const cv::Rect window = PixelsOf(result.cells);
  Draw(view, window);
  const auto smooth = [](const cv::Mat& image, cv::Mat& to) {
    image.convertTo(to, CV_32F);
    cv::GaussianBlur(to, to, {}, kSmoothingPx, kSmoothingPx, cv::BORDER_REPLICATE);
  };
  smooth(stored_, smooth_a_);
  smooth(seen_, smooth_b_);
  gains_.create(result.cells.size(), CV_32FC1);
  std::vector<BrightnessFit::Sample> samples;
  const auto cell_at = [](int col, int row) {
    return cv::Rect(col * kCellPx, row * kCellPx, kCellPx, kCellPx);
  };
  for (int row = 0; row < result.cells.height; ++row) {
    for (int col = 0; col < result.cells.width; ++col) {
      const cv::Rect cell = cell_at(col, row);
      if (!IsWhole(cell)) continue;
      const double a = cv::mean(smooth_a_(cell))[0];
      const double b = cv::mean(smooth_b_(cell))[0];
      if (std::min(a, b) < kDark || std::max(a, b) >= kLit) continue;
      const cv::Point2d centre = 0.5 * cv::Point2d(cell.tl() + cell.br() + 2 * window.tl());
      samples.push_back({centre, std::log(b / a)});
    }
  }
  result.fit = BrightnessFit(samples, window);
  LevelBy(result.fit, window);
  const auto variance = [](const cv::Mat& image) {
    const double sigma = registration::EstimateNoise(image);
    return sigma * sigma;
  };
  const double gain = cv::mean(gains_)[0];
  result.noise = variance(view.grey) / (gain * gain);
  const double noise = kNoiseLeft * (result.noise + variance(stored_)) + kRounding;
  result.states = cv::Mat(result.cells.size(), CV_8UC1, cv::Scalar(0));
  result.differences = cv::Mat(result.cells.size(), CV_32FC1, cv::Scalar(0));
  result.weights = cv::Mat(result.cells.size(), CV_32FC1, cv::Scalar(0));
  const double half = 0.5 * std::min(view.grey.cols, view.grey.rows);
  for (int row = 0; row < result.cells.height; ++row) {
    for (int col = 0; col < result.cells.width; ++col) {
      Judge(cell_at(col, row), {col, row}, noise, result);
      const cv::Point2d at =
          view.placement.ToPixel(grid.min_x + (window.x + (col + 0.5) * kCellPx) * grid.resolution,
                                 grid.max_y - (window.y + (row + 0.5) * kCellPx) * grid.resolution);
      const double to_border = std::min(std::min(at.x, view.grey.cols - 1 - at.x),
                                        std::min(at.y, view.grey.rows - 1 - at.y));
      result.weights.ptr<float>(row)[col] =
          static_cast<float>(std::clamp(to_border / half, 0.0, 1.0));
    }
  }
  seen_.setTo(0, valid_ == 0);
  result.levelled = seen_.clone();
  result.stored = stored_.clone();
  return result;
}

}  // namespace ceilmap::change
