#pragma once

#include <cstdint>
#include <vector>

namespace ceilmap::evaluation {

/// How errors are spread; of absolute values, in the unit of the errors.
struct ErrorStatistics {
  std::int64_t count = 0;
  double rmse = 0;  ///< root of the mean square
  double mean = 0;
  double median = 0;  ///< the 50th percentile
  double std = 0;     ///< about the mean, over `count` and not `count - 1`
  double min = 0;
  double max = 0;
  double p75 = 0;  ///< percentiles: linear between the neighbouring ranks
  double p90 = 0;
  double p95 = 0;
  double p99 = 0;
};

/// @param errors  at least one, finite. Cost: sorts them.
ErrorStatistics Statistics(std::vector<double> errors);

}  // namespace ceilmap::evaluation
