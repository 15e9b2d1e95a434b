#include "samples/simulator/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

std::array<float, 4> SplineWeights(double fraction) {
  const double rest = 1 - fraction;
  return {static_cast<float>(rest * rest * rest / 6),
          static_cast<float>(2.0 / 3 - fraction * fraction * (2 - fraction) / 2),
          static_cast<float>(2.0 / 3 - rest * rest * (2 - rest) / 2),
          static_cast<float>(fraction * fraction * fraction / 6)};
}

// Standard deviation of a cubic B-spline over independent values uniform in [-1, 1], over all
// positions: 1 / sqrt(3) times the mean of the squared weights, 151/315, of each direction.
const double kSplineDeviation = 151.0 / 315 / std::numbers::sqrt3;

struct Knot {
  std::int64_t cell;
  std::array<float, 4> weights;
};

Knot KnotAt(double at, double cell_m) {
  const double cells = at / cell_m;
  const double floor = std::floor(cells);
  return {static_cast<std::int64_t>(floor) - 1, SplineWeights(cells - floor)};
}

float LatticeValue(std::uint64_t key, std::int64_t x, std::int64_t y, std::int64_t period) {
  if (period > 0) {
    x = ((x % period) + period) % period;
    y = ((y % period) + period) % period;
  }
  return static_cast<float>(2 * UnitInterval(HashAt(key, x, y)) - 1);
}

/// A pit of Gaussian shape. Positions in metres.
struct Pit {
  double x, y;
  double length, width;  // standard deviations along and across its orientation
  double angle;
  double depth;
};

constexpr double kPitCell = 0.04;  // metres
constexpr int kPitsInCell = 4;
constexpr double kPitReach = 3.5;         // standard deviations
constexpr double kLongestPit = 0.006;     // standard deviation in metres
constexpr double kPitMean = 0.0574;       // of the pits' sum, by their density and volume
constexpr double kPitDeviation = 0.1032;  // of the sum, in samples 4 mm apart
constexpr double kMottle = 0.2;           // standard deviation relative to the pits' 1
constexpr double kMottleCell = 0.008;     // metres
constexpr double kFadingPitch = 0.02;  // metres between samples at which the grain begins to vanish

Pit PitAt(Random& random, double x0_m, double y0_m) {
  Pit pit{};
  pit.x = x0_m + random.Uniform(0, kPitCell);
  pit.y = y0_m + random.Uniform(0, kPitCell);
  pit.length = random.Uniform(0.0015, kLongestPit);
  pit.width = random.Uniform(0.001, 0.002);
  pit.angle = random.Uniform(0, std::numbers::pi);
  pit.depth = random.Uniform(0.3, 1);
  return pit;
}

/// The pit in samples that are the mean over a Gaussian of this standard deviation.
Pit Blurred(Pit pit, double blur_m) {
  const double volume = pit.depth * pit.length * pit.width;
  pit.length = std::hypot(pit.length, blur_m);
  pit.width = std::hypot(pit.width, blur_m);
  pit.depth = volume / (pit.length * pit.width);
  return pit;
}

/// Samples [first, last) of an axis within the range of a position.
std::pair<int, int> Within(double at_m, double reach_m, double start, double pitch_m, int count) {
  const double low = std::ceil((at_m - reach_m) / pitch_m - 0.5 - start);
  const double high = std::floor((at_m + reach_m) / pitch_m - 0.5 - start);
  return {static_cast<int>(std::clamp(low, 0.0, static_cast<double>(count))),
          static_cast<int>(std::clamp(high + 1, 0.0, static_cast<double>(count)))};
}

void Dig(const Pit& pit, double scale, const SampleGrid& grid, cv::Mat& samples) {
  const double c = std::cos(pit.angle);
  const double s = std::sin(pit.angle);
  const double reach_x = kPitReach * std::hypot(c * pit.length, s * pit.width);
  const double reach_y = kPitReach * std::hypot(s * pit.length, c * pit.width);
  const auto [u0, u1] =
      Within(pit.x, reach_x, static_cast<double>(grid.column0), grid.pitch_x_m, grid.columns);
  const auto [v0, v1] =
      Within(pit.y, reach_y, static_cast<double>(grid.row0), grid.pitch_y_m, grid.rows);
  const auto depth = static_cast<float>(pit.depth * scale);
  const double along_x = c / pit.length;
  const double across_x = -s / pit.width;
  for (int v = v0; v < v1; ++v) {
    const double dy = grid.Y(v) - pit.y;
    const double along_y = s * dy / pit.length;
    const double across_y = c * dy / pit.width;
    auto* const row = samples.ptr<float>(v);
    for (int u = u0; u < u1; ++u) {
      // From the position itself, not incrementally: a sample must not depend on its grid.
      const double dx = grid.X(u) - pit.x;
      const auto along = static_cast<float>(along_y + dx * along_x);
      const auto across = static_cast<float>(across_y + dx * across_x);
      row[u] -= depth * std::exp(-0.5F * (along * along + across * across));
    }
  }
}

}  // namespace

void AddSplineNoise(std::uint64_t key,
                    double cell_m,
                    double deviation,
                    const SampleGrid& grid,
                    cv::Mat& samples,
                    std::int64_t period_cells) {
  const double pitch = std::max(grid.pitch_x_m, grid.pitch_y_m);
  const double fade = std::clamp(cell_m / pitch - 1, 0.0, 1.0);
  if (deviation <= 0 || fade <= 0) return;
  const auto scale = static_cast<float>(deviation * fade / kSplineDeviation);
  std::vector<Knot> knots(static_cast<std::size_t>(grid.columns));
  for (int u = 0; u < grid.columns; ++u) knots[u] = KnotAt(grid.X(u), cell_m);
  const std::int64_t first_cell = knots.front().cell;
  std::vector<float> line(static_cast<std::size_t>(knots.back().cell - first_cell + 4));
  for (int v = 0; v < grid.rows; ++v) {
    const Knot row_knot = KnotAt(grid.Y(v), cell_m);
    for (std::size_t i = 0; i < line.size(); ++i) {
      line[i] = 0;
      for (int k = 0; k < 4; ++k) {
        const auto cell = first_cell + static_cast<std::int64_t>(i);
        line[i] += row_knot.weights[k] * LatticeValue(key, cell, row_knot.cell + k, period_cells);
      }
    }
    auto* out = samples.ptr<float>(v);
    for (int u = 0; u < grid.columns; ++u) {
      const float* at = &line[static_cast<std::size_t>(knots[u].cell - first_cell)];
      const auto& w = knots[u].weights;
      out[u] += scale * (w[0] * at[0] + w[1] * at[1] + w[2] * at[2] + w[3] * at[3]);
    }
  }
}

float SamplePeriodic(const cv::Mat& samples, double column, double row) {
  constexpr double kPeriods =
      1 << 20;  // offset to positive numbers, for which truncation is the floor
  const double x = column + kPeriods;
  const double y = row + kPeriods;
  const int u = static_cast<int>(x);
  const int v = static_cast<int>(y);
  const auto part_x = static_cast<float>(x - u);
  const auto part_y = static_cast<float>(y - v);
  const int columns = samples.cols;
  const float* const data = samples.ptr<float>();
  const float* const top = data + std::ptrdiff_t{v & (samples.rows - 1)} * columns;
  const float* const low = data + std::ptrdiff_t{(v + 1) & (samples.rows - 1)} * columns;
  const int left = u & (columns - 1);
  const int right = (u + 1) & (columns - 1);
  const float over = top[left] + part_x * (top[right] - top[left]);
  const float under = low[left] + part_x * (low[right] - low[left]);
  return over + part_y * (under - over);
}

void AddGrain(std::uint64_t key, const SampleGrid& grid, cv::Mat& samples) {
  const double pitch = std::max(grid.pitch_x_m, grid.pitch_y_m);
  const double fade = std::clamp(2 - pitch / kFadingPitch, 0.0, 1.0);
  if (fade <= 0 || samples.empty()) return;
  const double scale = fade / kPitDeviation;
  samples += cv::Scalar(scale * kPitMean);
  // Half a sample of blur suppresses most of the aliasing.
  const double blur_m = pitch / 2;
  const double reach_m = kPitReach * std::hypot(kLongestPit, blur_m);
  const auto cell = [](double at_m) {
    return static_cast<std::int64_t>(std::floor(at_m / kPitCell));
  };
  const std::int64_t last_x = cell(grid.X(grid.columns - 1) + reach_m);
  const std::int64_t last_y = cell(grid.Y(grid.rows - 1) + reach_m);
  for (std::int64_t y = cell(grid.Y(0) - reach_m); y <= last_y; ++y) {
    for (std::int64_t x = cell(grid.X(0) - reach_m); x <= last_x; ++x) {
      Random random(HashAt(key, x, y), Purpose::kSpeckle);
      for (int i = 0; i < kPitsInCell; ++i) {
        const Pit pit =
            PitAt(random, static_cast<double>(x) * kPitCell, static_cast<double>(y) * kPitCell);
        Dig(Blurred(pit, blur_m), scale, grid, samples);
      }
    }
  }
  AddSplineNoise(key, kMottleCell, kMottle, grid, samples);
}

}  // namespace ceilmap::simulator
