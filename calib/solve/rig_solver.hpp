#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/base/pose2.hpp"

namespace ceilmap::calibration {

/// How an upward camera is mounted, from what it saw of a level ceiling while the robot turned on
/// the spot and while it drove straight on.
///
/// Axes here are those of the camera's level twin: at its place, looking exactly up, turned about
/// z like the camera; x right and y down in the image, z up. The unit of length is the distance
/// Z of the ceiling above the camera, which a tape measure must give.

/// A place of the ceiling that two images show.
struct PointCorrespondence {
  /// Where, as (x/z, y/z) in the optical frame of the camera as it is mounted.
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  Eigen::Vector2d second = Eigen::Vector2d::Zero();
  /// Takes an error in pixels of the first image to one as far as the place lets it be seen
  /// (small along an edge); W'W is the inverse covariance up to a factor that all share.
  Eigen::Matrix2d whitening = Eigen::Matrix2d::Identity();
};

struct ViewPair {
  int first = 0;  ///< of the recording's views, from 0
  int second = 0;
  std::vector<PointCorrespondence> places;
};

/// One recording. A view's pose is that of the level twin, with the axle's foot as its origin, in
/// the frame of the first: p_first = T_first_view * (c + p_ceiling), c the camera's place.
struct Recording {
  std::vector<Pose2> cameras;  ///< rough poses of the camera itself, T_first_camera
  std::vector<ViewPair> pairs;
};

/// What is looked for.
struct RigMount {
  /// Rotation vector of the tilt, about x and y: p_twin = exp(tilt) p_cam.
  Eigen::Vector2d tilt_rad = Eigen::Vector2d::Zero();
  /// The camera's place, from the point about which the robot turns.
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  /// Of the camera in base: p_base = Rz(yaw) p_twin.
  double yaw_rad = 0;

  /// The camera's place in base's axes, from the middle of the axle, in units of Z.
  [[nodiscard]] Eigen::Vector2d CentreInBase() const;
};

struct RigSolverParams {
  double focal_px = 0;  ///< turns errors into pixels, > 0
  /// Error that the intrinsics may cause at the image's edge. It is the same in all images, so that
  /// no residual shows it: it enters the covariance as errors of focal length, principal point,
  /// distortion and skew of this size each.
  double lens_sigma_px = 0.05;
};

/// What was left at a view.
struct ViewError {
  double rms_px = 0;  ///< of its places, weighted
  int places = 0;
};

struct RigSolution {
  bool ok = false;
  RigMount mount;
  /// How far the camera went from the first view of the straight drive to the last, units of Z.
  double travel = 0;
  /// Of (tilt x, tilt y, centre x, centre y, yaw, travel). From the residuals, with all pairs that
  /// share a view taken for dependent (dyadic cluster-robust, Fafchamps & Gubert 2007): what is
  /// wrong with one image is wrong in each of its pairs. And from lens_sigma_px.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  std::vector<Pose2> spin;      ///< axle and heading at each view
  std::vector<Pose2> straight;  ///< the same, in the first view's frame
  std::vector<ViewError> spin_errors;
  std::vector<ViewError> straight_errors;
  double sigma_px = 0;  ///< robust deviation of a fully informative place, one axis
  int places = 0;       ///< seen twice
  int inliers = 0;      ///< of them, within three deviations
};

/// Rough start values from rough poses alone: a circle through those of the spin.
RigMount GuessMount(const Recording& spin, const Recording& straight);

/// Robust least squares (Ceres, Cauchy's loss on a robust scale that is found anew in each of
/// several rounds) over all places of both recordings: tilt, centre and yaw, and a free pose of
/// each view. The axle stays where it is in the spin, and moves along base x in the straight drive,
/// both up to what wheels do.
/// @param straight  may be empty: then the yaw stays at that of `start` and travel is 0.
RigSolution SolveRig(const Recording& spin,
                     const Recording& straight,
                     const RigMount& start,
                     const RigSolverParams& params);

}  // namespace ceilmap::calibration
