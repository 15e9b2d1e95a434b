#include "samples/simulator/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "samples/simulator/random.hpp"

namespace ceilmap::simulator {
namespace {

std::array<float, 4> SplineWeights(double part) {
  const double rest = 1 - part;
  return {static_cast<float>(rest * rest * rest / 6),
          static_cast<float>(2.0 / 3 - part * part * (2 - part) / 2),
          static_cast<float>(2.0 / 3 - rest * rest * (2 - rest) / 2),
          static_cast<float>(part * part * part / 6)};
}

// Standard deviation of a cubic B-spline over independent values uniform in [-1, 1], over all
// places: 1 / sqrt(3) times the mean of the squared weights, 151/315, of each direction.
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

struct Pit {
  double x, y, length, width, angle, depth;  // samples, radians
};

void Dig(const Pit& pit, double shrink_y, cv::Mat& speckle) {
  const int mask = speckle.cols - 1;
  const int reach = static_cast<int>(std::ceil(3 * pit.length)) + 1;
  const int u0 = static_cast<int>(pit.x);
  const int v0 = static_cast<int>(pit.y);
  const double c = std::cos(pit.angle);
  const double s = std::sin(pit.angle);
  for (int v = v0 - reach; v <= v0 + reach; ++v) {
    float* row = speckle.ptr<float>(v & mask);
    for (int u = u0 - reach; u <= u0 + reach; ++u) {
      const double dx = u - pit.x;
      const double dy = (v - pit.y) * shrink_y;
      const double along = (c * dx + s * dy) / pit.length;
      const double across = (c * dy - s * dx) / pit.width;
      const double squared = along * along + across * across;
      if (squared < 12) row[u & mask] -= static_cast<float>(pit.depth * std::exp(-squared / 2));
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

cv::Mat MakeSpeckle(std::uint64_t key, int size, double pitch_x_m, double pitch_y_m) {
  constexpr double kPitsPerM2 = 2500;
  cv::Mat speckle(size, size, CV_32FC1, cv::Scalar(0));
  Random random(key, Purpose::kSpeckle);
  for (int v = 0; v < size; ++v) {
    for (int u = 0; u < size; ++u) {
      speckle.at<float>(v, u) = static_cast<float>(random.Uniform(-0.12, 0.12));
    }
  }
  const double area_m2 = size * pitch_x_m * size * pitch_y_m;
  const auto count = static_cast<int>(std::min(kPitsPerM2 * area_m2, 3e5));
  for (int i = 0; i < count; ++i) {
    Pit pit{random.Uniform(0, size), random.Uniform(0, size), 0, 0, 0, 0};
    // A pit smaller than a sample is as wide as one and as much shallower.
    const double length = random.Uniform(0.0015, 0.006) / pitch_x_m;
    const double width = random.Uniform(0.001, 0.002) / pitch_x_m;
    pit.length = std::max(length, 0.6);
    pit.width = std::max(width, 0.6);
    pit.angle = random.Uniform(0, std::numbers::pi);
    pit.depth = random.Uniform(0.3, 1) * length * width / (pit.length * pit.width);
    Dig(pit, pitch_y_m / pitch_x_m, speckle);
  }
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(speckle, mean, deviation);
  speckle = (speckle - mean[0]) * (1 / deviation[0]);
  return speckle;
}

}  // namespace ceilmap::simulator
