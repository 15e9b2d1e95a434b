#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "localization/compass/panorama.hpp"

namespace ceilmap::labrosse {

/// Squared Euclidean distances of two panoramas for all circular shifts of columns, exact: value s
/// is the sum over pixels and channels of (current(v, u) - reference(v, (u - s) mod W))^2, for s =
/// 0 .. W-1. Cost: W^2 x rows x channels operations.
/// @throws InputError on panoramas that are empty, of another type, too wide, or of different sizes
///   or types.
std::vector<std::uint64_t> SquaredShiftDistances(const cv::Mat& reference, const cv::Mat& current);

/// The shift of least distance in whole columns, in (-W/2, W/2].
/// @param squared  Squared distances for all shifts 0 .. W-1, not empty.
/// @return nothing unless exactly one shift has the least distance, or two neighbouring shifts
///   share it; then the one nearer to 0.
std::optional<int> LeastShift(const std::vector<std::uint64_t>& squared);

/// The turn of the robot from one panorama to another.
struct ColumnShift {
  /// Columns by which the reference's content moved to the right, in (-W/2, W/2].
  int columns = 0;
  /// 2 pi columns / W, in (-pi, pi], counter-clockwise seen from above: a left turn decreases every
  /// azimuth and so moves the content to the right.
  double heading_change_rad = 0;
  double distance = 0;  ///< Euclidean distance of the panoramas at that shift, in grey levels
};

/// The shift with the least Euclidean distance over all shifts (Labrosse 2004, "Visual compass"),
/// in whole columns.
/// @return nothing when the panoramas do not determine the heading: when the least distance occurs
///   at several shifts, as at every shift of a uniform panorama, or once per period of a periodic
///   one. If exactly two neighbouring shifts have the same distance (the turn is half-way between
///   columns), the one nearer to 0 is returned.
/// @throws InputError as SquaredShiftDistances.
std::optional<ColumnShift> FindColumnShift(const cv::Mat& reference, const cv::Mat& current);

}  // namespace ceilmap::labrosse
