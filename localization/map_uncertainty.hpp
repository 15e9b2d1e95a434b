#pragma once

#include <Eigen/Core>
#include <future>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// Deformation of a map at any of its places, as a covariance: the part of a pose's error that no
/// match with the map can show, because the map itself has this error.
///
/// Computed from the map's edges (graph::GaugeFreeCovariances), and scaled up where the edges
/// disagree more than their covariances imply (MapQuality::chi2_per_dof). A ceiling with depth
/// adds the uncertainty of the map's scale, which no edge shows, about the middle of the map. Runs
/// in a thread of its own, started by the constructor; 0.2 s for 2000 keyframes. Not thread-safe.
class MapUncertainty {
 public:
  /// @param map  Must outlive the object.
  explicit MapUncertainty(const store::MapReader& map);

  /// Covariance of a pose's (x, y, yaw) by the map's error, in the map frame: that of the nearest
  /// keyframe. Zero for a map without this information.
  /// @throws InputError or RunError when the map's edges are damaged.
  [[nodiscard]] Eigen::Matrix3d At(const Pose2& T_map_base);

 private:
  struct Place {
    Eigen::Vector2d position;
    Eigen::Matrix3d covariance;
  };
  static std::vector<Place> Compute(const store::MapReader& map);

  std::vector<Place> places_;
  std::future<std::vector<Place>> computing_;
};

}  // namespace ceilmap::localization
