#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/base/pose2.hpp"

namespace ceilmap::compass {

/// The way of a camera on a robot whose poses become known a moment too late for the compass, by
/// going on as it went: PanoramaFrame::travel for those who map or localize beside it.
class TravelForecast {
 public:
  /// @param camera  where it stands on the robot, base frame, m. Off the axle it travels when the
  /// robot turns on the spot.
  explicit TravelForecast(const Eigen::Vector2d& camera = Eigen::Vector2d::Zero())
      : camera_(camera) {}

  /// A pose, or that there is none. Stamps must increase; others are left out.
  void See(double stamp_s, const std::optional<Pose2>& T_map_base);
  /// The way from one moment to a later one; nothing when the last two poses are not of the second
  /// before it.
  [[nodiscard]] std::optional<Eigen::Vector2d> Between(double from_s, double to_s) const;

 private:
  Eigen::Vector2d camera_;
  std::optional<Pose2> last_;
  double last_s_ = 0;
  std::optional<Eigen::Vector2d> velocity_m_s_;  // in base axes
};

}  // namespace ceilmap::compass
