#include "localization/compass/view_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "localization/compass/fields_of_view.hpp"

namespace ceilmap::compass {

using std::numbers::pi;

namespace {

// Number of rows to which panoramas are averaged beforehand, >= 1. About twelve are sufficient.
constexpr int kRows = 15;
// A turn with a smaller inlier ratio is rejected, [0, 1].
constexpr double kMinAcceptedRatio = 0.35;

constexpr int kThumbColumns = 72;
constexpr int kThumbRows = 5;

}  // namespace

ViewMatcher::ViewMatcher(const FftCompassParams& params, cv::Size size, int channels)
    : params_(params),
      distances_({size.width, std::min(kRows, size.height)}, channels),
      matcher_({size.width, std::min(kRows, size.height)}, channels),
      thumbs_({kThumbColumns, std::min(kThumbRows, size.height)}, 1),
      squared_(static_cast<std::size_t>(size.width)),
      thumb_squared_(kThumbColumns) {}

void ViewMatcher::Analyze(const cv::Mat& panorama, View& view) {
  const int rows = std::min(kRows, panorama.rows);
  cv::resize(panorama, pooled_, {panorama.cols, rows}, 0, 0, cv::INTER_AREA);
  distances_.Analyze(pooled_, view.spectrum);
  matcher_.Analyze(pooled_, view.lines);
  const bool coloured = distances_.Channels() == 3;
  if (coloured) cv::cvtColor(pooled_, grey_, cv::COLOR_BGR2GRAY);
  const cv::Size thumb(kThumbColumns, std::min(kThumbRows, panorama.rows));
  cv::resize(coloured ? grey_ : pooled_, thumb_, thumb, 0, 0, cv::INTER_AREA);
  thumbs_.Analyze(thumb_, view.thumb);
}

double ViewMatcher::LeastTurn(const View& reference, const View& current, double direction_rad) {
  const auto fields = FieldsOfView::FrontAndBack(direction_rad, params_.field_of_view_rad);
  distances_.Squared(reference.spectrum,
                     current.spectrum,
                     fields.ColumnWeights(Columns()),
                     ShiftDistances::Means::kIgnore,
                     squared_);
  const auto shift = std::min_element(squared_.begin(), squared_.end()) - squared_.begin();
  const int columns = Columns();
  return 2 * pi * static_cast<double>(2 * shift >= columns ? shift - columns : shift) / columns;
}

std::optional<ParallaxFit> ViewMatcher::Around(const View& reference,
                                               const View& current,
                                               double turn_rad,
                                               std::optional<double> direction_rad) {
  const double shift_columns = turn_rad * Columns() / (2 * pi);
  const auto sectors = matcher_.Measure(reference.lines, current.lines, shift_columns);
  const int asked = SectorMatcher::kSectors;
  ParallaxFit fit = direction_rad ? FitParallax(sectors, asked, *direction_rad)
                                  : FitParallaxOfAnyDirection(sectors, asked);
  if (!(fit.inlier_ratio >= kMinAcceptedRatio)) return std::nullopt;
  // Shifts outside the range around the expected shift were not searched.
  if (std::abs(fit.rotation_rad - turn_rad) > SectorMatcher::kSearchRad) return std::nullopt;
  return fit;
}

double ViewMatcher::Difference(const View& reference, const View& current) {
  thumbs_.Squared(
      reference.thumb, current.thumb, {}, ShiftDistances::Means::kIgnore, thumb_squared_);
  const double least = *std::min_element(thumb_squared_.begin(), thumb_squared_.end());
  return least / (reference.thumb.total_energy + current.thumb.total_energy);
}

}  // namespace ceilmap::compass
