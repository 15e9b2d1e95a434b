#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace ceilmap::calibration {

/// Orientation of a forward camera on the robot, from its images during a known motion of the robot
/// (measured by the ceiling).
///
/// What tells what: a turn on the spot moves the image about the vertical, which gives pitch and
/// roll; a straight drive moves it away from the point that the robot drives to, which gives pitch
/// and yaw.

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
  /// Of a small turn about base's axes (x: roll, y: nose down, z: to the left), rad^2. From the
  /// curvature, large where no motion determines it; by leaving out stretches of the recordings one
  /// after the other (delete-a-group jackknife), so that errors of the motion, which all matches of
  /// a image share, count as often as they occur; and from systematic_px, systematic_rad and
  /// lens_sigma_px.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double sigma_px = 0;  ///< robust standard deviation of a match from its line
  std::size_t matches = 0;
  std::size_t inliers = 0;  ///< number of them within three standard deviations
};

/// Robust least squares (Ceres, Cauchy's loss) over the rotation alone. What a match is off by is
/// its distance from where the second image shows what the first one did, at whatever depth from
/// 0.3 m to infinity fits best: the epipolar line's half that is ahead of the camera. A
/// camera that turns without moving has a point instead of a line, and needs no special case.
/// @param motions  of one recording after the other, in order of time.
/// @param start  the camera in base: its rotation to begin with (within some 10 degrees), its place
///   as measured, m, which stays. A place wrong by 1 cm changes the result little.
ForwardMount SolveForwardMount(const std::vector<MotionWithMatches>& motions,
                               const Eigen::Isometry3d& start,
                               const ForwardMountParams& params);

}  // namespace ceilmap::calibration
