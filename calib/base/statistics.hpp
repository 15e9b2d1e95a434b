#pragma once

#include <vector>

namespace ceilmap {

/// The median; of an even number of values the upper of the two middle ones. 0 when there are no
/// values. Cost: linear.
double Median(std::vector<double> values);

}  // namespace ceilmap
