#include "localization/compass/labrosse/shift_minimum.hpp"

#include <algorithm>
#include <limits>

namespace ceilmap::labrosse {

double ParabolaMinimum(const ShiftNeighbours& distances) {
  const auto [left, least, right] = distances;
  const double curvature = left - 2 * least + right;
  return curvature > 0 ? (left - right) / (2 * curvature) : 0;
}

double VMinimum(const ShiftNeighbours& distances) {
  const auto [left, least, right] = distances;
  const double slope = std::max(left, right) - least;
  return slope > 0 ? (left - right) / (2 * slope) : 0;
}

double BlendedMinimum(const ShiftNeighbours& distances, double amplitude) {
  return amplitude * VMinimum(distances) + (1 - amplitude) * ParabolaMinimum(distances);
}

double NormalizedAmplitude(std::span<const double> distances) {
  if (distances.empty()) return 0;
  const auto [least, largest] = std::minmax_element(distances.begin(), distances.end());
  return *largest > 0 ? (*largest - *least) / *largest : 0;
}

double ShiftVariance(const ShiftNeighbours& distances, double independent_columns) {
  const auto [left, least, right] = distances;
  const double curvature = left * left - 2 * least * least + right * right;
  if (!(curvature > 0)) return std::numeric_limits<double>::infinity();
  return 2 * least * least / (independent_columns * curvature);
}

}  // namespace ceilmap::labrosse
