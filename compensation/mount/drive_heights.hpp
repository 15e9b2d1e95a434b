#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calib/solve/drive_solver.hpp"
#include "compensation/mount/measured.hpp"

namespace ceilmap::mount {

/// The ceiling's plane among the heights of a drive: the farthest surface that covers a large part
/// of what is seen (heights::FindReference), to whose height the rig's `h` belongs. Its standard
/// deviation is how much the quarters of the drive disagree.
/// @param views  of the drive.
/// @return rho of the plane; nothing where no surface stands out in most of the drive, or much is
///   seen beyond it: then it is something that hangs below a ceiling without texture.
std::optional<Measured> ReferencePlane(const std::vector<calibration::PointHeight>& heights,
                                       std::size_t views);

/// Takes the distance of another plane as the unit of length of poses and heights.
/// @param rho  of that plane.
void TakeAsPlane(double rho, calibration::DriveSolution& solution);

}  // namespace ceilmap::mount
