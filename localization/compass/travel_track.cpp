#include "localization/compass/travel_track.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace ceilmap::compass {

void TravelTrack::Move(const std::optional<Eigen::Vector2d>& travel) {
  if (!travel) {
    travel_.setZero();
    direction_rad_ = 0;
    ++last_.stretch;
    return;
  }
  travel_ = *travel;
  if (!travel_.isZero(0)) direction_rad_ = std::atan2(travel_.y(), travel_.x());
}

Eigen::Vector2d TravelTrack::Here(double heading_rad) const {
  return last_.at + Eigen::Rotation2Dd(heading_rad) * travel_;
}

double TravelTrack::DirectionFrom(const Spot& place, double turn_rad, double heading_rad) const {
  const Eigen::Vector2d moved = Here(heading_rad) - place.at;
  if (place.stretch != last_.stretch || moved.isZero(0)) return direction_rad_ - 0.5 * turn_rad;
  return std::atan2(moved.y(), moved.x()) - heading_rad;
}

TravelTrack::Spot TravelTrack::Arrive(double heading_rad) {
  last_.at = Here(heading_rad);
  travel_.setZero();
  return last_;
}

}  // namespace ceilmap::compass
