#pragma once

#include <cstddef>
#include <vector>

namespace ceilmap::page {

/// `keep` of the indices 0 ... count - 1, evenly chosen, the first and the last among them; all of
/// them where keep >= count.
std::vector<std::size_t> EvenIndices(std::size_t count, std::size_t keep);

/// Indices of the points that draw the same curve as all of `y`: of each of about keep / 4 equal
/// stretches the first, the least, the greatest, and a gap (NaN) if there is one. At most `keep`
/// and the last; all of them where keep >= y.size().
/// @param keep  >= 4.
std::vector<std::size_t> CurveIndices(const std::vector<double>& y, std::size_t keep);

}  // namespace ceilmap::page
