#include "localization/compass/sector_shifts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/registration/kernels.hpp"

namespace ceilmap::compass {
namespace {

// Width of each sector (a raised cosine of twice this width at its base), in (0, pi/2]. A narrow
// sector has nearly one shift under travel; a wide sector contains more texture.
constexpr double kWidthRad = 0.105;

// Content wider than this is removed from the lines, rad: an edge between wall and ceiling, hedge
// and sky, that runs along the travel changes its height slowly around the circle and stays in
// place in the panorama; where a wall is bare nothing else is seen, and it would tell a motion of
// 0.
constexpr double kBroadRad = 0.14;

using std::numbers::pi;

std::size_t Count(int n) {
  return static_cast<std::size_t>(n);
}

CEILMAP_HOT void AddSquaredDifferences(const float* a, const float* b, int n, float* sum) {
  for (int i = 0; i < n; ++i) {
    const float off = a[i] - b[i];
    sum[i] += off * off;
  }
}

CEILMAP_HOT void Unpack(const std::uint8_t* row, int channels, int columns, float* line) {
  for (int u = 0; u < columns; ++u) line[u] = static_cast<float>(row[u * channels]);
}

/// line = samples minus their mean over 2 half + 1 columns, around the circle.
void SubtractLocalMean(std::span<const float> samples, int half, float* line) {
  const int columns = static_cast<int>(samples.size());
  double sum = 0;
  for (int u = -half; u <= half; ++u) sum += samples[Count((u + columns) % columns)];
  for (int u = 0; u < columns; ++u) {
    line[u] = samples[Count(u)] - static_cast<float>(sum / (2 * half + 1));
    const int next = u + half + 1;
    const int last = u - half;
    sum += samples[Count(next < columns ? next : next - columns)] -
           samples[Count(last < 0 ? last + columns : last)];
  }
}

CEILMAP_HOT float WeightedSum(const float* values, const float* weights, int n) {
  // Independent partial sums, because a compiler may not reorder floating-point additions itself.
  constexpr int kLanes = 16;
  float sums[kLanes] = {};
  int i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) sums[lane] += values[i + lane] * weights[i + lane];
  }
  float sum = 0;
  for (; i < n; ++i) sum += values[i] * weights[i];
  for (const float part : sums) sum += part;
  return sum;
}

}  // namespace

SectorMatcher::SectorMatcher(cv::Size size, int channels)
    : columns_(size.width), rows_(size.height), channels_(channels) {
  const double columns_per_rad = columns_ / (2 * pi);
  // A parabola and the test of its depth need at least two columns to either side.
  reach_ = std::clamp(static_cast<int>(std::lround(kSearchRad * columns_per_rad)),
                      std::min(3, (columns_ - 1) / 2),
                      (columns_ - 1) / 2);
  const int half = std::clamp(static_cast<int>(std::lround(kWidthRad * columns_per_rad)),
                              std::min(2, (columns_ - 1) / 2),
                              (columns_ - 1) / 2);
  for (int i = -half; i <= half; ++i) {
    window_.push_back(static_cast<float>(0.5 + 0.5 * std::cos(pi * i / (half + 1))));
  }
  stride_ = columns_ + static_cast<int>(window_.size());
  volume_.Resize(Count(2 * reach_ + 1) * Count(stride_));
  doubled_.resize(Count(columns_ + 2 * reach_ + 2));
  cost_.resize(Count(2 * reach_ + 1));
  shifts_.reserve(Count(kSectors));
}

void SectorMatcher::Analyze(const cv::Mat& panorama, PanoramaLines& lines) {
  lines.samples.Resize(Count(rows_ * channels_) * Count(columns_));
  const int half = std::clamp(
      static_cast<int>(std::lround(0.5 * kBroadRad * columns_ / (2 * pi))), 1, (columns_ - 1) / 2);
  lines.energy.Resize(Count(columns_));
  lines.slopes.Resize(Count(columns_));
  std::fill_n(lines.energy.data(), columns_, 0.F);
  std::fill_n(lines.slopes.data(), columns_, 0.F);
  row_.resize(Count(columns_));
  for (int i = 0; i < rows_ * channels_; ++i) {
    Unpack(panorama.ptr(i / channels_) + i % channels_, channels_, columns_, row_.data());
    float* line = lines.samples.data() + Count(i) * Count(columns_);
    SubtractLocalMean(row_, half, line);
    for (int u = 0; u < columns_; ++u) {
      const float slope = line[u + 1 < columns_ ? u + 1 : 0] - line[u > 0 ? u - 1 : columns_ - 1];
      lines.energy[Count(u)] += line[u] * line[u];
      lines.slopes[Count(u)] += slope * slope;
    }
  }
}

/// volume_(k, u) = sum over lines of (current(u) - reference(u - s))^2, s = expected + k - reach_.
void SectorMatcher::Compare(const PanoramaLines& reference,
                            const PanoramaLines& current,
                            int expected) {
  std::fill_n(volume_.data(), volume_.size(), 0.F);
  const int lines = rows_ * channels_;
  // doubled_(i) = reference(i - expected - reach_): the largest shift begins at 0.
  const int first = ((-expected - reach_) % columns_ + columns_) % columns_;
  for (int line = 0; line < lines; ++line) {
    const float* from = reference.samples.data() + Count(line) * Count(columns_);
    for (int i = 0, u = first; i < columns_ + 2 * reach_; ++i) {
      doubled_[Count(i)] = from[u];
      if (++u == columns_) u = 0;
    }
    const float* to = current.samples.data() + Count(line) * Count(columns_);
    for (int k = 0; k <= 2 * reach_; ++k) {
      AddSquaredDifferences(to,
                            doubled_.data() + (2 * reach_ - k),
                            columns_,
                            volume_.data() + Count(k) * Count(stride_));
    }
  }
  // The columns at the seam are repeated, so that windows need not wrap.
  for (int k = 0; k <= 2 * reach_; ++k) {
    float* costs = volume_.data() + Count(k) * Count(stride_);
    std::copy_n(costs, window_.size(), costs + columns_);
  }
}

/// Under the window that begins at a column, which may lie beyond the seam.
double SectorMatcher::Energy(const PanoramaLines& lines, int first) const {
  double sum = 0;
  int u = (first % columns_ + columns_) % columns_;
  for (const float weight : window_) {
    sum += weight * lines.energy[Count(u)];
    if (++u == columns_) u = 0;
  }
  return sum;
}

/// Mean column under that window, where each counts by what it contributes to the curvature of the
/// distance: the squares of the slopes. The measured shift is the one there, not that of the
/// middle of the window.
double SectorMatcher::Centroid(const PanoramaLines& lines, int first) const {
  double sum = 0;
  double moment = 0;
  int u = first;
  for (int i = 0; i < static_cast<int>(window_.size()); ++i) {
    const double weight = window_[Count(i)] * lines.slopes[Count(u)];
    sum += weight;
    moment += weight * i;
    if (++u == columns_) u = 0;
  }
  return first + (sum > 0 ? moment / sum : 0.5 * static_cast<double>(window_.size() - 1));
}

void SectorMatcher::MeasureSector(const PanoramaLines& reference,
                                  const PanoramaLines& current,
                                  int sector,
                                  int expected) {
  const int half = static_cast<int>(window_.size()) / 2;
  const double middle = (sector + 0.5) * columns_ / kSectors - 0.5;
  const int centre = static_cast<int>(std::lround(middle));
  const int first = (centre - half + columns_) % columns_;
  double mean = 0;
  for (int k = 0; k <= 2 * reach_; ++k) {
    const float* costs = volume_.data() + Count(k) * Count(stride_) + first;
    const double sum = WeightedSum(costs, window_.data(), static_cast<int>(window_.size()));
    cost_[Count(k)] = sum;
    mean += sum / (2 * reach_ + 1);
  }
  const auto least = std::min_element(cost_.begin(), cost_.end());
  const int k = static_cast<int>(least - cost_.begin());
  // A shallow minimum is caused by noise; a minimum at the edge of the range is not a minimum.
  constexpr double kShallow = 0.8;
  if (k == 0 || k == 2 * reach_ || !(*least < kShallow * mean)) return;
  // Where one of the two shows nothing of the other, e.g. in the dark, the least distance is where
  // the other is bare.
  constexpr double kUnexplained = 0.8;
  const double energy = Energy(current, first) + Energy(reference, first - (expected + k - reach_));
  if (!(*least < kUnexplained * energy)) return;
  const double before = cost_[Count(k - 1)];
  const double after = cost_[Count(k + 1)];
  const double curvature = before - 2 * *least + after;
  if (!(curvature > 0)) return;
  const double shift = expected + k - reach_ + 0.5 * (before - after) / curvature;
  // Number of independent samples under the window.
  constexpr double kIndependent = 15;
  const double rad_per_column = 2 * pi / columns_;
  shifts_.push_back({WrapAngle(pi - rad_per_column * Centroid(current, first)),
                     shift * rad_per_column,
                     2 * *least / (curvature * kIndependent) * rad_per_column * rad_per_column});
}

std::span<const SectorShift> SectorMatcher::Measure(const PanoramaLines& reference,
                                                    const PanoramaLines& current,
                                                    double expected_columns) {
  const int expected = static_cast<int>(std::lround(expected_columns));
  Compare(reference, current, expected);
  shifts_.clear();
  for (int sector = 0; sector < kSectors; ++sector)
    MeasureSector(reference, current, sector, expected);
  return shifts_;
}

}  // namespace ceilmap::compass
