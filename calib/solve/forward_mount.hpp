#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace ceilmap::calibration {

/// Orientation of a forward camera on the robot, from its images during a known motion of the robot
/// (measured by the ceiling).
///
/// A turn on the spot moves the image about the vertical, which determines pitch and roll; a
/// straight drive moves it away from the vanishing point of the motion, which determines pitch and
/// yaw.

/// Positions of one point of the room in two images, as (x/z, y/z) in the optical frame.
struct Match {
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Vector2d second = Eigen::Vector2d::Zero();
};

/// A pair of images of a recording.
struct MotionWithMatches {
  Eigen::Isometry3d T_first_second = Eigen::Isometry3d::Identity();  ///< of base
  std::vector<Match> matches;
};

struct ForwardMountParams {
  double focal_px = 0;           ///< turns errors into pixels, > 0
  double sigma_floor_px = 0.02;  ///< lower bound of the matches' standard deviation
  /// Common error of all matches, which no residual shows: corners that grow as the camera comes
  /// nearer, the image's compression. It enters the covariance as shifts of this size along both
  /// axes, and as a zoom and a rotation of this size at the image's edge.
  double systematic_px = 0.05;
  /// Common error of all motions, rad: objects below the ceiling move more than it does and change
  /// the direction of travel. It is added to the covariance.
  double systematic_rad = 5e-4;
  double lens_sigma_px = 0.05;  ///< error of the principal point; see RigSolverParams
};

struct ForwardMount {
  bool ok = false;  ///< false: too few matches, or none that agree
  Eigen::Matrix3d R_base_cam = Eigen::Matrix3d::Identity();
  /// Of a small rotation about the axes of base (x: roll, y: nose down, z: to the left), rad^2.
  /// From the curvature, large where no motion determines it; from a delete-a-group jackknife over
  /// parts of the recordings, which accounts for errors of the motion that all matches of an image
  /// share; and from systematic_px, systematic_rad and lens_sigma_px.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double sigma_px = 0;  ///< robust standard deviation of a match from its line
  std::size_t matches = 0;
  std::size_t inliers = 0;  ///< number of them within three standard deviations
};

/// Robust least squares (Ceres, Cauchy's loss) over the rotation. The residual of a match is its
/// distance from the half epipolar line ahead of the camera, i.e. from the best position for any
/// depth from 0.3 m to infinity. For a camera that rotates without translation the line
/// becomes a point, without a special case.
/// @param motions  Of the recordings one after the other, in order of time.
/// @param start  The camera in base: the initial rotation (within about 10 degrees), and the
/// measured position, m, which is not changed. A position error of 1 cm changes the result little.
ForwardMount SolveForwardMount(const std::vector<MotionWithMatches>& motions,
                               const Eigen::Isometry3d& start,
                               const ForwardMountParams& params);

}  // namespace ceilmap::calibration
