#pragma once

#include <Eigen/Core>
#include <future>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// How far a map is bent, at any of its places: the part of a pose's error that no look at the map
/// can show, because the map itself is off there.
///
/// Computed from the map's edges (graph::GaugeFreeCovariances), scaled up where these disagree more
/// than they claim (MapQuality::chi2_per_dof), in a thread of its own beginning with the
/// constructor; 0.2 s for 2000 keyframes. Not thread-safe.
class MapUncertainty {
 public:
  /// @param map  must outlive the object.
  explicit MapUncertainty(const store::MapReader& map);

  /// Covariance of a pose's (x, y, yaw) by the map's error, in the map frame: that of the nearest
  /// keyframe. Zero for a map of which nothing is known.
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
