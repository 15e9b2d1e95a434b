#pragma once

#include "calib/rig.hpp"
#include "calib/solve/drive_solver.hpp"

namespace ceilmap::mount {

/// Adds to the covariance of a solution how much parts of the drive disagree with it: the quarters
/// of its time, and pairs of views that are near to each other, farther apart and far apart. Under
/// a ceiling with depth the errors of points are not random. Those by heights grow with the
/// distance of the views, those of the camera do not.
/// @param up, drive, unknowns  of which the solution is. @param solution  Is ok.
void AddSpreadOfParts(const calib::MountedCamera& up,
                      const calibration::Drive& drive,
                      const calibration::DriveUnknowns& unknowns,
                      calibration::DriveSolution& solution);

}  // namespace ceilmap::mount
