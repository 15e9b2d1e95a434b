#pragma once

#include <cstdint>
#include <vector>

namespace ceilmap::evaluation {

/// Distribution of the absolute values of errors, in the unit of the errors.
struct ErrorStatistics {
  std::int64_t count = 0;
  double rmse = 0;  ///< root of the mean square
  double mean = 0;
  double median = 0;  ///< the 50th percentile
  double std = 0;     ///< around the mean, with the divisor `count`, not `count - 1`
  double min = 0;
  double max = 0;
  double p75 = 0;  ///< percentiles: linear interpolation between neighbouring ranks
  double p90 = 0;
  double p95 = 0;
  double p99 = 0;
};

/// @param errors  At least one, finite. Cost: sorting them.
ErrorStatistics Statistics(std::vector<double> errors);

}  // namespace ceilmap::evaluation
