#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/base/pose2.hpp"
#include "calib/rig.hpp"
#include "calib/solve/rig_solver.hpp"

namespace ceilmap::calibration {

/// Errors of an upward camera's rig, from its images of a level ceiling during any drive with
/// turns: no other measurement is needed. The axes and the unit of length are those of the rig
/// solver (rig_solver.hpp): of the camera levelled by the rig, and the distance Z of the ceiling.

/// A drive: views in order of time, and the points that pairs of them show.
struct Drive {
  std::vector<Pose2> cameras;  ///< rough poses T_first_camera
  std::vector<ViewVelocity> velocities;
  std::vector<std::size_t> starts;  ///< first views of parts that share no points; the first is 0
  std::vector<ViewPair> pairs;      ///< of the camera as the rig states it
};

/// Indices of the values of CameraErrors.
enum CameraError : int {
  kCameraTiltX,  ///< rotation of the camera about the levelled x and y, rad
  kCameraTiltY,
  kCameraFocal,    ///< the focal length is 1 / (1 - value) times the rig's
  kCameraRadial3,  ///< displacement at the edge of a pixel's place in the image outwards that the
                   ///< lens
  kCameraRadial5,  ///< model lacks, px, with the third and the fifth power of the radius
  kCameraReadout,  ///< read-out time itself, s
  kCameraErrors
};
using CameraErrors = Eigen::Matrix<double, kCameraErrors, 1>;

/// What a drive is to determine beside tilt, yaw and the poses.
struct DriveUnknowns {
  bool focal = false;  ///< whether these are estimated
  bool radial = false;
  bool readout = true;
  /// Heights of the points that have an index: each has its own, in all pairs that show it.
  /// Otherwise all are in the plane.
  bool heights = false;
};

/// Height of a point that a view shows.
struct PointHeight {
  int view = 0;
  int index = 0;   ///< PointCorrespondence::index
  double rho = 1;  ///< Z divided by the point's distance
  double sigma = 0;
};

struct DriveSolution {
  bool ok = false;
  CameraErrors errors = CameraErrors::Zero();
  /// From the residuals: with all pairs that share a view, or an eighth of the drive, taken as
  /// correlated, whichever gives more. Values that the drive does not determine have a large
  /// variance.
  Eigen::Matrix<double, kCameraErrors, kCameraErrors> covariance =
      Eigen::Matrix<double, kCameraErrors, kCameraErrors>::Zero();
  std::vector<Pose2> cameras;  ///< of the views
  std::vector<ViewError> view_errors;
  double edge_px = 0;   ///< largest distance of a point from the principal point
  double sigma_px = 0;  ///< robust standard deviation of a fully informative point, one axis
  /// Robust standard deviation of the points' heights relative to Z: 0 for a plane ceiling.
  double depth_ratio = 0;
  std::vector<PointHeight> heights;  ///< of DriveUnknowns::heights
  int places = 0;
  int inliers = 0;
};

/// Robust least squares (Ceres, Cauchy's loss) over all points: the camera's errors and a free pose
/// of each view. Where the ceiling has depth, only the errors across the direction of travel count:
/// along it, a point below the plane moves farther.
/// @param up  the camera as the rig states it.
DriveSolution SolveDrive(const calib::MountedCamera& up,
                         const Drive& drive,
                         const DriveUnknowns& params);

/// Heights of all points of a drive that have an index, with the camera and the poses of a
/// solution: of each the median of its pairs.
std::vector<PointHeight> HeightsOf(const calib::MountedCamera& up,
                                   const Drive& drive,
                                   const DriveSolution& solution);

}  // namespace ceilmap::calibration
