#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "calib/rig.hpp"
#include "samples/simulator/scene.hpp"

namespace ceilmap::simulator {

/// The robot's poses while a camera's shutter is open, of a rolling shutter from the first row's
/// exposure to that of the last one.
struct Exposure {
  Eigen::Isometry3d T_map_base;  ///< at the middle
  Eigen::Isometry3d T_map_base_open;
  Eigen::Isometry3d T_map_base_close;
  double half_s = 0;  ///< from the middle to both
};

/// The pose at a time after the middle, from -half_s to half_s.
Eigen::Isometry3d PoseDuring(const Exposure& exposure, double after_middle_s);

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

/// Times whose mean image has the blur of the whole exposure: one without blur, more with
/// increasing blur. -1: the shutter opens, 1: it closes.
std::vector<double> TimesOfBlur(double blur_px);

}  // namespace ceilmap::simulator
