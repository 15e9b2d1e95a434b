#pragma once

#include <optional>

namespace ceilmap::calib {

/// A unit in which lengths are given by mistake.
struct LengthUnit {
  const char* name;
  double per_metre;
};

/// The lengths that a quantity has in most rigs, as absolute values.
struct UsualLengths {
  double least_m = 0;
  double most_m = 0;
};

/// The unit, millimetres or centimetres, in which a number is a usual length; nothing when none is
/// or both are.
std::optional<LengthUnit> UnitOf(double value, const UsualLengths& usual);

}  // namespace ceilmap::calib
