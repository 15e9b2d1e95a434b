#include "app/evaluation/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace ceilmap::evaluation {
namespace {

// Value at a fractional rank of sorted values, as in numpy.percentile.
double AtRank(const std::vector<double>& sorted, double fraction) {
  const double rank = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (sorted[above] - sorted[below]) * (rank - static_cast<double>(below));
}

}  // namespace

ErrorStatistics Statistics(std::vector<double> errors) {
  for (double& error : errors) error = std::abs(error);
  std::sort(errors.begin(), errors.end());
  const auto count = static_cast<double>(errors.size());
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / count;
  double squares = 0;
  double deviations = 0;
  for (const double error : errors) {
    squares += error * error;
    deviations += (error - mean) * (error - mean);
  }
  return {.count = static_cast<std::int64_t>(errors.size()),
          .rmse = std::sqrt(squares / count),
          .mean = mean,
          .median = AtRank(errors, 0.5),
          .std = std::sqrt(deviations / count),
          .min = errors.front(),
          .max = errors.back(),
          .p75 = AtRank(errors, 0.75),
          .p90 = AtRank(errors, 0.9),
          .p95 = AtRank(errors, 0.95),
          .p99 = AtRank(errors, 0.99)};
}

}  // namespace ceilmap::evaluation
