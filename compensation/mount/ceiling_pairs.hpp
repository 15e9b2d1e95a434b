#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/base/twist2.hpp"
#include "calib/rig.hpp"
#include "calib/solve/rig_solver.hpp"
#include "compensation/mount/ceiling_recording.hpp"
#include "mapping/heights/height_field.hpp"

namespace ceilmap::mount {

/// The motion of a recording's camera as far as it is known, in units of the ceiling's distance.
struct KnownMotion {
  std::vector<Pose2> cameras;                         ///< T_first_camera of the keyframes
  std::vector<calibration::ViewVelocity> velocities;  ///< at the keyframes
  /// Heights that the keyframes show, nullptr: a plane. Empty: nothing is known of heights.
  std::vector<std::shared_ptr<const heights::HeightField>> heights = {};
};

/// A velocity of the camera as one of base.
/// @param T_base_camera  the levelled camera. @param distance_m  of the ceiling from it.
Twist2 InBase(const calibration::ViewVelocity& velocity,
              const Eigen::Isometry3d& T_base_camera,
              double distance_m);

/// Ceiling points that two keyframes show, for many pairs: consecutive keyframes, and keyframes
/// farther apart as long as they overlap by at least 35 %.
/// @param up  the camera as far as it is known.
/// @param motion  The images of a rolling shutter are drawn with its velocities.
/// @param accurate  camera and poses are known to one or two pixels over the image. Otherwise the
///   motion of each pair is refined first, tilt included. Where heights are known, it is true.
/// @param blocks  Maximum number of points of a pair, where heights are known.
calibration::Recording MeasurePairs(const CeilingRecording& recording,
                                    const calib::MountedCamera& up,
                                    double ceiling_height_m,
                                    const KnownMotion& motion,
                                    bool accurate,
                                    int blocks = 64);

}  // namespace ceilmap::mount
