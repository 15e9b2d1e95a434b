#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/pose_with_covariance.hpp"
#include "calib/base/similarity2.hpp"

/// A map in the coordinates of its building: surveyed points, and the transform that they
/// determine.
namespace ceilmap::survey {

/// A point whose coordinates are known in the map and in the building.
struct ControlPoint {
  std::string name;                                 ///< unique among the points of a map, not empty
  Eigen::Vector2d p_map = Eigen::Vector2d::Zero();  ///< map units
  Eigen::Vector2d p_site = Eigen::Vector2d::Zero();  ///< metres, x right or east, y up or north
  /// Standard deviation of p_site - S_site_map * p_map on each axis, metres: of picking, surveying
  /// and the map together. 0: the default of AlignOptions.
  double sigma_m = 0;
};

/// A control point after the alignment.
struct AlignedPoint {
  ControlPoint point;                                    ///< sigma_m > 0
  Eigen::Vector2d residual_m = Eigen::Vector2d::Zero();  ///< p_site - S_site_map * p_map
  /// False: the point contradicts the others, and S_site_map does not depend on it.
  bool used = true;
  /// Length of the residual that the point has when it is not used; nothing where the remaining
  /// points do not determine the transform.
  std::optional<double> leave_one_out_m;
};

/// The building's coordinate system, and the map in it.
struct SiteFrame {
  Similarity2 S_site_map;  ///< p_site = S_site_map * p_map, metres
  /// The standard deviations below are of independent errors of the transform at this point.
  Eigen::Vector2d centre_map = Eigen::Vector2d::Zero();
  double sigma_position_m = 0;  ///< of the position of centre_map in the site, on each axis
  double sigma_yaw_rad = 0;
  double sigma_scale = 0;  ///< relative; 0: the scale was not estimated
  /// Coordinate reference system of the site as WKT 2; empty: a local one of the building.
  std::string crs_wkt;
  std::vector<AlignedPoint> points;
};

/// A pose of the map in the coordinates of the site. Its covariance has the error of the alignment
/// added, which is the same for all poses of the map.
PoseWithCovariance ToSite(const SiteFrame& site, const PoseWithCovariance& T_map_base);

/// A pose of the site in the map, with the same addition.
PoseWithCovariance ToMap(const SiteFrame& site, const PoseWithCovariance& T_site_base);

}  // namespace ceilmap::survey
