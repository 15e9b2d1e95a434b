#pragma once

#include <Eigen/Core>
#include <optional>

namespace ceilmap::compass {

/// Where panoramas were taken, by adding up what is known of the way between them: which way the
/// place of a reference lies decides where a turn shows and where travel does.
class TravelTrack {
 public:
  /// Place of a panorama, comparable with others of the same stretch of known travel.
  struct Spot {
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
    int stretch = -1;
  };

  /// Begins a frame. @param travel  since the last one, seen from the robot now
  /// (PanoramaFrame::travel). Nothing: unknown, and places before can not be compared with it.
  void Move(const std::optional<Eigen::Vector2d>& travel);
  /// Direction of travel seen from the robot now, rad; the last one known while it stands, and
  /// ahead where nothing is known.
  [[nodiscard]] double Direction() const { return direction_rad_; }
  /// Direction of the way from a place to here, seen from the robot, which has turned by `turn_rad`
  /// since and has the heading `heading_rad` now. Of places that cannot be compared: that of an
  /// arc, on which the robot came along a chord, seen from here half a turn back.
  [[nodiscard]] double DirectionFrom(const Spot& place, double turn_rad, double heading_rad) const;
  /// Ends a frame. @return its place.
  Spot Arrive(double heading_rad);

 private:
  [[nodiscard]] Eigen::Vector2d Here(double heading_rad) const;

  Spot last_{Eigen::Vector2d::Zero(), 0};
  Eigen::Vector2d travel_ = Eigen::Vector2d::Zero();
  double direction_rad_ = 0;
};

}  // namespace ceilmap::compass
