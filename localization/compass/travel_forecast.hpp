#pragma once

#include <Eigen/Core>
#include <optional>

#include "calib/base/pose2.hpp"

namespace ceilmap::compass {

/// Displacement of a camera on a robot whose poses become available slightly too late for the
/// compass, predicted by a constant-velocity model. It provides PanoramaFrame::travel to programs
/// that map or localize at the same time.
class TravelForecast {
 public:
  /// @param camera  Position on the robot, base frame, m. A camera that is not above the axle's
  ///   centre travels when the robot turns on the spot.
  explicit TravelForecast(const Eigen::Vector2d& camera = Eigen::Vector2d::Zero())
      : camera_(camera) {}

  /// Adds a pose, or the fact that there is none. Stamps must increase; others are ignored.
  void Add(double stamp_s, const std::optional<Pose2>& T_map_base);
  /// Displacement from one time to a later one; nothing unless the last two poses lie within the
  /// second before it.
  [[nodiscard]] std::optional<Eigen::Vector2d> Between(double from_s, double to_s) const;

 private:
  Eigen::Vector2d camera_;
  std::optional<Pose2> last_;
  double last_s_ = 0;
  std::optional<Eigen::Vector2d> velocity_m_s_;  // in base axes
};

}  // namespace ceilmap::compass
