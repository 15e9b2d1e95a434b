#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

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
/// keyframe keeps its pose. A measurement that contradicts the rest loses its weight (the loss of
/// loop closures). Covariances and quality are those with the measurements.
/// @param S_site_map  Approximately; its scale is used and not changed.
/// @throws InputError for a measurement of a missing keyframe, or a standard deviation <= 0.
void Straighten(MapGraph& graph,
                std::span<const ControlMeasurement> measurements,
                const Similarity2& S_site_map,
                const PoseGraphParams& params = {});

}  // namespace ceilmap::graph
