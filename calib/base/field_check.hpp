#pragma once

#include <string_view>

namespace ceilmap {

/// Checks the fields of a params struct: `Validate()` makes one and calls it for each field.
class FieldCheck {
 public:
  /// @param owner  what the fields belong to, e.g. "odometry"; must outlive this.
  explicit FieldCheck(std::string_view owner) : owner_(owner) {}

  /// @throws InputError "OWNER: FIELD = VALUE, must be RANGE" unless `valid`.
  void operator()(bool valid, std::string_view field, double value, std::string_view range) const;

 private:
  std::string_view owner_;
};

}  // namespace ceilmap
