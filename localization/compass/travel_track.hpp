#pragma once

#include <Eigen/Core>
#include <optional>

namespace ceilmap::compass {

/// Positions at which panoramas were taken, summed from the known displacements between them. The
/// direction to the place of a reference determines at which azimuths a turn is visible and at
/// which travel is.
class TravelTrack {
 public:
  /// Position of a panorama, comparable with others of the same uninterrupted stretch of known
  /// travel.
  struct Spot {
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
    int stretch = -1;
  };

  /// Begins a frame.
  /// @param travel  Displacement since the last frame, seen from the robot now
  ///   (PanoramaFrame::travel). Empty: unknown; earlier places then cannot be compared with this
  ///   one.
  void Move(const std::optional<Eigen::Vector2d>& travel);
  /// Direction of travel seen from the robot now, rad. While the robot stands still: the last known
  /// direction. Where nothing is known: straight ahead.
  [[nodiscard]] double Direction() const { return direction_rad_; }
  /// Direction of the displacement from a place to the current position, seen from the robot, which
  /// has turned by `turn_rad` since then and has the heading `heading_rad` now. For places that
  /// cannot be compared the robot is assumed to have driven an arc: the direction of its chord,
  /// which is the direction of travel rotated back by half the turn.
  [[nodiscard]] double DirectionFrom(const Spot& place, double turn_rad, double heading_rad) const;
  /// Ends a frame. @return its position.
  Spot Arrive(double heading_rad);

 private:
  [[nodiscard]] Eigen::Vector2d Here(double heading_rad) const;

  Spot last_{Eigen::Vector2d::Zero(), 0};
  Eigen::Vector2d travel_ = Eigen::Vector2d::Zero();
  double direction_rad_ = 0;
};

}  // namespace ceilmap::compass
