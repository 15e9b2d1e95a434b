#pragma once

#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::mount {

/// A pose and its time.
struct TimedPose {
  double stamp_s = 0;
  Pose2 pose;
};

/// Velocity of a path at one of its poses, in that pose's axes: a parabola through the poses near
/// it, at least two on each side, as far as the path has them.
/// @param path  Stamps increase. @param index  of the pose.
calibration::ViewVelocity VelocityAt(const std::vector<TimedPose>& path, std::size_t index);

/// Velocities of views whose poses became known more accurately than the path of all images.
/// The direction of each step is that of the accurate poses of the views next to it; the rate at
/// which the camera follows the path is that of the images.
/// @param rough  poses of the views on the path of all images, at least two.
/// @param velocities  of that path at the views, in their axes.
/// @param accurate  the same views; may have another first pose.
std::vector<calibration::ViewVelocity> RefineVelocities(
    const std::vector<Pose2>& rough,
    const std::vector<calibration::ViewVelocity>& velocities,
    const std::vector<Pose2>& accurate);

/// Velocities of views whose poses and times are known, from each view and its neighbours alone: a
/// parabola through them. For views that follow each other closely.
/// @param views  at least two; stamps increase.
std::vector<calibration::ViewVelocity> VelocitiesOf(const std::vector<TimedPose>& views);

}  // namespace ceilmap::mount
