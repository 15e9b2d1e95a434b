#include "calib/unit_slip.hpp"

#include <cmath>

namespace ceilmap::calib {

std::optional<LengthUnit> UnitOf(double value, const UsualLengths& usual) {
  const auto is_usual = [&](const LengthUnit& unit) {
    const double metres = std::abs(value) / unit.per_metre;
    return metres >= usual.least_m && metres <= usual.most_m;
  };
  constexpr LengthUnit kMillimetre{"millimetres", 1000};
  constexpr LengthUnit kCentimetre{"centimetres", 100};
  const bool millimetre = is_usual(kMillimetre);
  if (millimetre == is_usual(kCentimetre)) return std::nullopt;
  return millimetre ? kMillimetre : kCentimetre;
}

}  // namespace ceilmap::calib
