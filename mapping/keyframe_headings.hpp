#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "calib/heading.hpp"

namespace ceilmap::mapping {

/// What a compass said at the keyframes of a recording, for the turn between any two of them.
class KeyframeHeadings {
 public:
  /// @param noise_rad  what a single heading is off at the least, > 0.
  explicit KeyframeHeadings(double noise_rad) : noise_rad_(noise_rad) {}

  /// @param id  >= 0, larger than those before.
  void Add(std::int64_t id, const calib::HeadingPrior& heading);
  /// See calib::TurnBetween; nothing unless both have a heading. Looks at all keyframes between:
  /// microseconds for ten thousand of them.
  [[nodiscard]] std::optional<calib::HeadingTurn> Turn(std::int64_t from, std::int64_t to) const;

 private:
  double noise_rad_;
  std::optional<double> least_rad2_;                          // of all variances
  std::vector<std::optional<calib::HeadingPrior>> headings_;  // by id
};

}  // namespace ceilmap::mapping
