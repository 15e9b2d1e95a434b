#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "calib/rig.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The robot's poses while a camera's shutter is open.
struct Exposure {
  Eigen::Isometry3d T_map_base;  ///< at the middle
  Eigen::Isometry3d T_map_base_open;
  Eigen::Isometry3d T_map_base_close;
};

/// Points in the corners of an upward camera's image, on the plane at a height above the floor.
std::vector<Eigen::Vector3d> PlaneInCorners(const calib::MountedCamera& camera,
                                            const Eigen::Isometry3d& T_map_base,
                                            double height_m);

/// Points of the empty room at nine positions of any camera's image, corners included.
std::vector<Eigen::Vector3d> RoomInImage(const calib::MountedCamera& camera,
                                         const Eigen::Isometry3d& T_map_base,
                                         const Room& room);

/// Largest motion of the points in the image during the exposure, pixels.
double BlurLength(const calib::MountedCamera& camera,
                  const Exposure& exposure,
                  const std::vector<Eigen::Vector3d>& points_map);

/// A moment of an exposure.
struct Moment {
  Eigen::Isometry3d T_map_base;
  double time = 0;  ///< -1: the shutter opens, 1: it closes
};

/// Moments whose mean image has the blur of the whole exposure: one without blur, more with
/// increasing blur.
std::vector<Moment> MomentsDuring(const Exposure& exposure, double blur_px);

}  // namespace ceilmap::simulator
