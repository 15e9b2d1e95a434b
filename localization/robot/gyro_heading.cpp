#include "localization/robot/gyro_heading.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calib/base/pose2.hpp"

namespace ceilmap::robot {
namespace {

// After a gap the robot may have turned by any angle.
constexpr double kUnknownTurnRad2 = std::numbers::pi * std::numbers::pi;
constexpr double kMinVarianceRad2 = 1e-10;  // of the first heading, which defines the direction

}  // namespace

GyroHeading::GyroHeading() {
  report_.sensor = HeadingSensor::kGyro;
}

std::optional<HeadingPrior> GyroHeading::At(double /*stamp_s*/,
                                            const Image* /*image*/,
                                            const std::optional<wheels::RelativeTurn>& turn) {
  if (turn) {
    turned_ = turned_ + *turn;
  } else if (began_) {
    turned_.noise_rad2 += kUnknownTurnRad2;
    ++report_.missing;
    return std::nullopt;
  }
  began_ = true;
  const double variance_rad2 = std::max(turned_.Variance(), kMinVarianceRad2);
  ++report_.headings;
  report_.last_sigma_rad = std::sqrt(variance_rad2);
  return HeadingPrior{WrapAngle(turned_.turn_rad), variance_rad2};
}

}  // namespace ceilmap::robot
