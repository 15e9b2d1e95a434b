#pragma once

#include <vector>

namespace ceilmap {

/// The middle value by rank; of an even number the upper of the two in the middle. 0 of none.
/// Cost: linear.
double Median(std::vector<double> values);

}  // namespace ceilmap
