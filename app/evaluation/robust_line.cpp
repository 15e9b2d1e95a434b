#include "app/evaluation/robust_line.hpp"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "calib/base/statistics.hpp"

namespace ceilmap::evaluation {
namespace {

struct Line {
  double offset = 0;
  double slope = 0;
};

std::optional<Line> WeightedLine(std::span<const double> x,
                                 std::span<const double> y,
                                 std::span<const double> weights) {
  double sum = 0;
  double sum_x = 0;
  double sum_y = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sum += weights[i];
    sum_x += weights[i] * x[i];
    sum_y += weights[i] * y[i];
  }
  if (!(sum > 0)) return std::nullopt;
  const double mean_x = sum_x / sum;
  const double mean_y = sum_y / sum;
  double xx = 0;
  double xy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += weights[i] * (x[i] - mean_x) * (x[i] - mean_x);
    xy += weights[i] * (x[i] - mean_x) * (y[i] - mean_y);
  }
  if (!(xx > 0)) return std::nullopt;
  return Line{mean_y - xy / xx * mean_x, xy / xx};
}

double MedianMagnitude(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return Median(std::move(values));
}

}  // namespace

std::optional<double> RobustSlope(std::span<const double> x, std::span<const double> y) {
  constexpr double kTuning = 4.685;
  constexpr double kNormal = 0.6745;  // median of the magnitude of a standard normal deviate
  constexpr int kMaxRounds = 50;
  constexpr double kConverged = 1e-9;
  std::vector<double> weights(x.size(), 1.0);
  std::optional<Line> line = WeightedLine(x, y, weights);
  std::vector<double> residuals(x.size());
  for (int round = 0; line && round < kMaxRounds; ++round) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      residuals[i] = y[i] - line->offset - line->slope * x[i];
    }
    const double reach = kTuning * MedianMagnitude(residuals) / kNormal;
    if (!(reach > 0)) break;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double ratio = residuals[i] / reach;
      weights[i] = std::abs(ratio) < 1 ? std::pow(1 - ratio * ratio, 2) : 0;
    }
    const std::optional<Line> next = WeightedLine(x, y, weights);
    if (!next) break;
    const double change = std::abs(next->slope - line->slope);
    line = next;
    if (change <= kConverged * std::abs(line->slope)) break;
  }
  if (!line) return std::nullopt;
  return line->slope;
}

}  // namespace ceilmap::evaluation
