#include "localization/compass/labrosse/shift_minimum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ceilmap::labrosse {

SubPixelMinimum ParabolicMinimum(const ShiftNeighbours& distances) {
  const auto [left, least, right] = distances;
  const double curvature = left - 2 * least + right;
  if (!(curvature > 0)) return {0, least};
  const double difference = left - right;
  return {difference / (2 * curvature), least - difference * difference / (8 * curvature)};
}

SubPixelMinimum LinearMinimum(const ShiftNeighbours& distances) {
  const auto [left, least, right] = distances;
  const double slope = std::max(left, right) - least;
  if (!(slope > 0)) return {0, least};
  return {(left - right) / (2 * slope), least - std::abs(left - right) / 2};
}

SubPixelMinimum BlendedMinimum(const ShiftNeighbours& distances, double p) {
  const SubPixelMinimum linear = LinearMinimum(distances);
  const SubPixelMinimum parabolic = ParabolicMinimum(distances);
  return {p * linear.shift + (1 - p) * parabolic.shift,
          p * linear.distance + (1 - p) * parabolic.distance};
}

double LinearPart(double normalized_amplitude) {
  return std::clamp((normalized_amplitude - 0.5) / 0.5, 0.0, 1.0);
}

double RelativeDepth(std::span<const double> distances) {
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
