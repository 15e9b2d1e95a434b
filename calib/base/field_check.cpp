#include "calib/base/field_check.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"

namespace ceilmap {

void FieldCheck::operator()(bool valid,
                            std::string_view field,
                            double value,
                            std::string_view range) const {
  if (valid) return;
  throw InputError(fmt::format("{}: {} = {}, must be {}", owner_, field, value, range));
}

}  // namespace ceilmap
