#pragma once

#include <numbers>
#include <optional>

#include "calib/base/heading.hpp"
#include "calib/wheels/relative_motion.hpp"
#include "localization/robot/heading_source.hpp"

namespace ceilmap::robot {

/// Variance of a turn of which nothing is known.
inline constexpr double kAnyTurnRad2 = std::numbers::pi * std::numbers::pi;

/// Headings by a gyro alone: the sum of its turns from one upward frame to the next. They count
/// from the first frame, and their variance grows with the noise and the bias of the gyro.
class GyroHeading {
 public:
  GyroHeading() { report_.sensor = HeadingSensor::kGyro; }

  /// The heading at the next upward frame.
  /// @param turn  since the upward frame before; nothing: the gyro does not tell it, or there was
  /// none. Then the heading is not known, and the next one is independent of those before.
  std::optional<HeadingPrior> Next(const std::optional<wheels::RelativeTurn>& turn);
  [[nodiscard]] const HeadingReport& Report() const { return report_; }

 private:
  wheels::RelativeTurn turned_;  // since the first frame
  bool began_ = false;
  HeadingReport report_;
};

}  // namespace ceilmap::robot
