#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// A box or a cylinder anywhere in the room, in any orientation. p_map = T_map_solid * p_solid.
struct Solid {
  Eigen::Isometry3d T_map_solid = Eigen::Isometry3d::Identity();
  Eigen::Vector3d low{0, 0, 0};  ///< corners in the solid's frame, low < high in each coordinate
  Eigen::Vector3d high{1, 1, 1};
  /// A cylinder: its axis is parallel to the solid's x axis through the middle of the corners, its
  /// diameter is high.y - low.y (= high.z - low.z).
  bool is_round = false;
  double brightness = 0.3;  ///< of the underside; other faces are darker
  double contrast = 0;      ///< standard deviation of the weak texture, relative
  /// Of the texture, metres along both axes of a face, so that solids differ.
  Eigen::Vector2d texture_offset{0, 0};
};

/// A known point of an object in the room.
struct NamedPoint {
  std::string name;
  Eigen::Vector3d p_map{0, 0, 0};
};

/// What stands or hangs between floor and ceiling.
struct Objects {
  std::vector<Solid> solids;
  std::vector<NamedPoint> points;
};

/// The solid of a box: its frame stands on the floor below the box's centre.
Solid SolidOf(const Box& box, double contrast);

/// A bar of rectangular cross-section between the centres of its ends, different points. Its width
/// is horizontal unless the bar is vertical.
Solid Bar(const Eigen::Vector3d& from_map,
          const Eigen::Vector3d& to_map,
          double width_m,
          double depth_m);

/// A cylinder between the centres of its ends, different points.
Solid Rod(const Eigen::Vector3d& from_map, const Eigen::Vector3d& to_map, double diameter_m);

/// A corner in map. @param index  0..7: bit i set for the high value of coordinate i.
Eigen::Vector3d Corner(const Solid& solid, int index);

/// The smallest box in map, parallel to its axes, around the solid's corners.
Eigen::AlignedBox3d Bounds(const Solid& solid);

}  // namespace ceilmap::simulator
