#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "calib/base/pose2.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Deviation of the robot from level. pitch > 0: nose up, about the line where the axle's wheels
/// touch the floor. roll > 0: left side up, about base x through the middle of that line.
struct Tilt {
  double pitch_rad = 0;
  double roll_rad = 0;
  [[nodiscard]] bool IsLevel() const { return pitch_rad == 0 && roll_rad == 0; }
};

/// The tilt after a distance travelled by the axle: the sum of all bumps there, exactly level
/// outside bumps.
Tilt TiltAt(const Debris& debris, double distance_m);

/// The bumps of uneven ground over a distance: each of Debris::uneven_length_m, one every half of
/// it, random and independent in pitch and roll, so that their sum is smooth and has no period.
/// Empty on a level floor.
std::vector<Bump> UnevenGround(const Debris& debris, std::uint64_t seed, double distance_m);

/// T_map_base = Trans(x, y, 0) Rz(yaw) Ry(-pitch) Rx(roll) Trans(a, 0, 0): the wheels of the axle
/// remain on the floor, the foot of the mast rises by a sin(pitch).
/// @param T_map_axle  Middle of the axle, on the floor.
Eigen::Isometry3d TiltedBase(const Pose2& T_map_axle, const Tilt& tilt, double axle_behind_mast_m);

}  // namespace ceilmap::simulator
