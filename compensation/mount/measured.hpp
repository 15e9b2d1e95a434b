#pragma once

namespace ceilmap::mount {

/// A value with its standard deviation, both in the unit of the field's name.
struct Measured {
  double value = 0;
  double sigma = 0;
};

}  // namespace ceilmap::mount
