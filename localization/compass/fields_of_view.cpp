#include "localization/compass/fields_of_view.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "calib/base/error.hpp"

namespace ceilmap::compass {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

}  // namespace

FieldsOfView FieldsOfView::FrontAndBack(double travel_direction_rad, double width_rad) {
  return {.centres_rad = {travel_direction_rad, travel_direction_rad + std::numbers::pi},
          .width_rad = width_rad};
}

void FieldsOfView::Validate() const {
  if (!(width_rad > 0 && width_rad <= kTurn)) {
    throw InputError(
        fmt::format("fields of view: width_rad = {}, must be in (0, 2 pi]", width_rad));
  }
  if (centres_rad.empty()) {
    throw InputError("fields of view: centres_rad is empty, must hold at least one angle");
  }
  for (const double centre_rad : centres_rad) {
    if (std::isfinite(centre_rad)) continue;
    throw InputError(
        fmt::format("fields of view: centres_rad holds {}, must be finite", centre_rad));
  }
}

std::vector<float> FieldsOfView::ColumnWeights(int columns) const {
  // A column on the edge stays inside despite the rounding of angles.
  constexpr double kEdgeColumns = 1e-6;
  const double half_columns = width_rad / kTurn * columns / 2 + kEdgeColumns;
  std::vector<float> weights(static_cast<std::size_t>(columns), 0.0F);
  for (const double centre_rad : centres_rad) {
    const double centre_column = (0.5 - centre_rad / kTurn) * columns;
    for (int u = 0; u < columns; ++u) {
      if (std::abs(std::remainder(u - centre_column, columns)) <= half_columns) {
        weights[static_cast<std::size_t>(u)] = 1;
      }
    }
  }
  return weights;
}

}  // namespace ceilmap::compass
