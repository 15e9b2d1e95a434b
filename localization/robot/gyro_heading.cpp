#include "localization/robot/gyro_heading.hpp"

#include <algorithm>
#include <cmath>

#include "calib/base/pose2.hpp"

namespace ceilmap::robot {
namespace {

constexpr double kMinVarianceRad2 = 1e-10;  // of the first heading, which defines the direction

}  // namespace

std::optional<HeadingPrior> GyroHeading::Next(const std::optional<wheels::RelativeTurn>& turn) {
  if (turn) {
    turned_ = turned_ + *turn;
  } else if (began_) {
    turned_.noise_rad2 += kAnyTurnRad2;
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
