#pragma once

#include <vector>

#include "mapping/survey/site_frame.hpp"

namespace ceilmap::survey {

struct AlignOptions {
  /// The scale between map and site is estimated too. Otherwise it is 1: a map with a rig has true
  /// metres, and a difference of scale is an error of the rig that should be seen.
  bool estimate_scale = false;
  /// Standard deviation of points that state none, on each axis, metres, 1e-6 to 1e6.
  double sigma_m = 0.01;

  /// @throws InputError that names field, value and range.
  void Validate() const;
};

/// The transform between map and building, estimated from control points.
struct Alignment {
  SiteFrame site;  ///< without crs_wkt; points in the given order
  /// Factor by which residuals are larger than the points' standard deviations, at least 1. The
  /// standard deviations of `site` are multiplied by it.
  double sigma_ratio = 1;
  double rms_m = 0;                ///< of the residuals of the points used, of both axes together
  double leave_one_out_rms_m = 0;  ///< of the errors that each point has when it is not used
  int used = 0;
  /// True when an error of any single point would be noticed: without one of them, the remaining
  /// points still check each other. Two points check each other only by their distance.
  bool checked = false;
};

/// Estimates the building's coordinates of a map: least squares, weighted by the points' standard
/// deviations. A minority of wrong points (mistyped, confused) is found and not used: the
/// transforms by all pairs of points are compared by the least median of squares (Rousseeuw 1984),
/// and the points that agree with the best one are fitted, until they do not change. The threshold
/// follows from the residuals, at least from the points' standard deviations, so that a map that is
/// bent more than assumed does not lose its points.
///
/// @param points  at least two, names unique, coordinates within 1e9, sigma_m as that of the
/// options or 0.
/// @throws InputError where the points do not determine the transform: too few, in one place, or
/// no majority of them agrees; and where they agree with another unit or a mirrored axis instead,
/// which is named.
Alignment Align(const std::vector<ControlPoint>& points, const AlignOptions& params = {});

}  // namespace ceilmap::survey
