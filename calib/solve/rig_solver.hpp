#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "calib/base/pose2.hpp"

namespace ceilmap::calibration {

/// Mount of an upward camera, from its images of a level ceiling while the robot turns on the spot
/// and drives straight ahead.
///
/// The axes are those of the levelled camera: at the same position, pointing exactly up, rotated
/// about z like the camera; x right and y down in the image, z up. The unit of length is the
/// distance Z of the ceiling above the camera, which a tape measure must give.

/// A point of the ceiling in two images.
struct PointCorrespondence {
  /// Position as (x/z, y/z) in the optical frame of the mounted camera.
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Vector2d second = Eigen::Vector2d::Zero();
  /// Of a rolling shutter: the row of the raw image that showed it, from -0.5 (the first one) to
  /// 0.5 (the last one).
  double first_row = 0;
  double second_row = 0;
  /// Weight matrix of an error in pixels of the first image (small along an edge); W'W is the
  /// inverse covariance up to a common factor.
  Eigen::Matrix2d whitening = Eigen::Matrix2d::Identity();
  /// The same number in pairs with the same first view: the same point. -1: unknown.
  int index = -1;
  double rho = 1;  ///< Z divided by the point's distance, as far as it is known
};

/// Velocity of the levelled camera at the time of a view, in the view's axes.
struct ViewVelocity {
  Eigen::Vector2d linear = Eigen::Vector2d::Zero();  ///< units of Z per second
  double yaw_rad_s = 0;
};

struct ViewPair {
  int first = 0;  ///< index of the recording's views, from 0
  int second = 0;
  std::vector<PointCorrespondence> places;
};

/// One recording. A view's pose is that of the levelled camera, with the axle's foot as its origin,
/// in the frame of the first view: p_first = T_first_view * (c + p_ceiling), c the camera's
/// position.
struct Recording {
  std::vector<Pose2> cameras;  ///< rough poses of the camera itself, T_first_camera
  /// One for each view; empty: at rest.
  std::vector<ViewVelocity> velocities;
  std::vector<ViewPair> pairs;
};

/// The unknowns.
struct RigMount {
  /// Rotation vector of the tilt, about x and y: p_level = exp(tilt) p_cam.
  Eigen::Vector2d tilt_rad = Eigen::Vector2d::Zero();
  /// The camera's position, relative to the rotation centre.
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  /// Of the camera in base: p_base = Rz(yaw) p_level.
  double yaw_rad = 0;
  /// Rolling shutter, as calib::MountedCamera::readout_time_s.
  double readout_time_s = 0;

  /// The camera's position in base's axes, relative to the middle of the axle, in units of Z.
  [[nodiscard]] Eigen::Vector2d CentreInBase() const;
};

/// Indices of RigSolution::covariance.
enum RigUnknown : std::uint8_t {
  kTiltX,
  kTiltY,
  kCentreX,
  kCentreY,
  kYaw,
  kTravel,
  kReadout,
  kRigUnknowns
};
using RigCovarianceMatrix = Eigen::Matrix<double, kRigUnknowns, kRigUnknowns>;

struct RigSolverParams {
  double focal_px = 0;  ///< turns errors into pixels, > 0
  /// Error that the intrinsics may cause at the image's edge. It is the same in all images, so that
  /// no residual shows it: it enters the covariance as errors of focal length, principal point,
  /// distortion and skew of this size each.
  double lens_sigma_px = 0.05;
};

/// Residuals of a view.
struct ViewError {
  double rms_px = 0;  ///< of its points, weighted
  int places = 0;
};

struct RigSolution {
  bool ok = false;
  RigMount mount;
  /// Distance of the camera between the first and last view of the straight drive, units of Z.
  double travel = 0;
  /// Of RigUnknown; zero for a value that is not an unknown. From the residuals, with all pairs
  /// that share a view taken as correlated (dyadic cluster-robust, Fafchamps & Gubert 2007),
  /// because an error of an image affects all of its pairs. And from lens_sigma_px.
  RigCovarianceMatrix covariance = RigCovarianceMatrix::Zero();
  std::vector<Pose2> spin;      ///< axle and heading at each view
  std::vector<Pose2> straight;  ///< the same, in the first view's frame
  std::vector<ViewError> spin_errors;
  std::vector<ViewError> straight_errors;
  double sigma_px = 0;  ///< robust standard deviation of a fully informative point, one axis
  int places = 0;       ///< points in two images
  int inliers = 0;      ///< number of them within three standard deviations
};

/// Initial values from rough poses: a circle through those of the spin.
RigMount GuessMount(const Recording& spin, const Recording& straight);

/// Robust least squares (Ceres, Cauchy's loss on a robust scale that is estimated anew in each of
/// several rounds) over all points of both recordings: tilt, centre, yaw and read-out time, and a
/// free pose of each view. The axle does not move in the spin, and moves along base x in the
/// straight drive, both up to errors of the wheels. A row of a rolling shutter sees the ceiling
/// from where the view's velocity has moved the camera; the velocities are not unknowns.
/// @param straight  May be empty: then the yaw remains that of `start` and travel is 0.
/// @param readout_is_free  The read-out time is an unknown; false: it remains that of `start`.
RigSolution SolveRig(const Recording& spin,
                     const Recording& straight,
                     const RigMount& start,
                     const RigSolverParams& params,
                     bool readout_is_free = false);

}  // namespace ceilmap::calibration
