#pragma once

#include <algorithm>
#include <vector>

namespace ceilmap::bench {

/// The value in the middle, the upper one of two; 0 of none.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace ceilmap::bench
