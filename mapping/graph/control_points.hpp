#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "calib/base/similarity2.hpp"
#include "mapping/graph/map_graph.hpp"

namespace ceilmap::graph {

/// A surveyed point that an image of a keyframe shows.
struct ControlMeasurement {
  std::int64_t keyframe_id = 0;
  Eigen::Vector2d p_base = Eigen::Vector2d::Zero();  ///< where the image shows it, map units
  Eigen::Vector2d p_site = Eigen::Vector2d::Zero();  ///< in the building, metres
  double sigma_m = 0.01;  ///< standard deviation of both together on each axis, metres > 0
};

/// Moves the keyframes of an optimized map so that it also agrees with surveyed points: the poses
/// of least squared error given all edges, all measurements, and an unknown pose of the building.
/// A map without loops, which bends because nothing contradicts it, becomes straight. The first
/// keyframe keeps its pose.
///
/// A bend has causes that all edges have in common (lens, mounting), which their covariances do not
/// contain. The covariances are enlarged until the measurements fit as well as their standard
/// deviations say. A measurement that alone requires a much larger factor contradicts the others
/// and is not used; at least five measurements remain.
/// @param S_site_map  Approximately; its scale is used and not changed.
/// @return for each measurement, whether it was used.
/// @throws InputError for a measurement of a missing keyframe, or a standard deviation <= 0.
std::vector<bool> Straighten(MapGraph& graph,
                             std::span<const ControlMeasurement> measurements,
                             const Similarity2& S_site_map,
                             const PoseGraphParams& params = {});

}  // namespace ceilmap::graph
