#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "calib/rig.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// Where the robot is while a camera's shutter is open.
struct Exposure {
  Eigen::Isometry3d T_map_base;  ///< in its middle
  Eigen::Isometry3d T_map_base_open;
  Eigen::Isometry3d T_map_base_close;
};

/// What the corners of an upward camera's image show of the ceiling.
std::vector<Eigen::Vector3d> CeilingInCorners(const calib::MountedCamera& camera,
                                              const Eigen::Isometry3d& T_map_base,
                                              double ceiling_height_m);

/// What nine places of any camera's image, corners included, show of the empty room.
std::vector<Eigen::Vector3d> RoomInImage(const calib::MountedCamera& camera,
                                         const Eigen::Isometry3d& T_map_base,
                                         const Room& room);

/// Largest way in pixels that the points move in the image during the exposure.
double BlurLength(const calib::MountedCamera& camera,
                  const Exposure& exposure,
                  const std::vector<Eigen::Vector3d>& points_map);

/// The robot's poses whose mean image has the blur of the whole exposure: one without blur, more
/// the longer it is.
std::vector<Eigen::Isometry3d> PosesDuring(const Exposure& exposure, double blur_px);

}  // namespace ceilmap::simulator
