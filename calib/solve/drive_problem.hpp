#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calib/rig.hpp"
#include "calib/solve/drive_residual.hpp"
#include "calib/solve/drive_solver.hpp"
#include "calib/solve/pair_problem.hpp"

namespace ceilmap::calibration {

/// A point with an unknown height.
struct KnownHeight {
  int view = 0;
  int index = 0;
  double rho = 1;  ///< as far as it is known
};

/// The points of a drive, without those beyond the lens model.
/// @param edge_px  receives the largest distance from the principal point.
/// @param heights  receives the points that have an index; nullptr: heights are no unknowns.
std::vector<DrivePoint> PreparePoints(const calib::MountedCamera& up,
                                      const Drive& drive,
                                      double& edge_px,
                                      std::vector<KnownHeight>* heights);

struct DriveParameters {
  std::array<double, kCameraErrors> errors{};
  std::vector<std::array<double, 3>> cameras;
  std::vector<double> heights;  ///< rho
};

/// Standard deviations of the camera's errors before anything is seen: values that a drive does not
/// determine stay near those of the rig.
inline constexpr std::array<double, kCameraErrors> kPriorSigma{0.5, 0.5, 0.3, 100, 100, 0.2};
/// The same of a height (rho). All heights together and the travel may have any scale: it stays
/// that of the known heights.
inline constexpr double kHeightSigma = 0.3;

/// Standard deviations of the residuals.
struct DriveScales {
  double place_px = 1;
  double depth_ratio = 0;
};

/// The point's error (ErrorOf) at the parameters.
Eigen::Vector2d DriveError(const DriveParameters& parameters, const DrivePoint& point);
/// The same for a point at another height, of which the error is a linear function.
Eigen::Vector2d DriveErrorAt(double rho,
                             const DriveParameters& parameters,
                             const DrivePoint& point);

/// The problem of a drive. The camera's errors are the first free parameters.
struct DriveProblem : PairProblem {
  DriveProblem(const std::vector<DrivePoint>& points,
               const Drive& drive,
               double focal_px,
               const DriveScales& scales,
               const DriveUnknowns& params,
               const std::vector<KnownHeight>& heights,
               DriveParameters& parameters);

  std::vector<int> estimated;  ///< columns of the errors: indices of CameraError
  int heights = 0;             ///< the last columns

 private:
  void AddHeights(const std::vector<KnownHeight>& known, DriveParameters& parameters);
};

}  // namespace ceilmap::calibration
