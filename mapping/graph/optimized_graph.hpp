#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/graph/map_graph.hpp"

/// What Optimize and Straighten have in common: the results of a solution. Internal.
namespace ceilmap::graph {

/// Residuals of the graph's edges at the poses (by id), except the counts of loops.
void MeasureQuality(const MapGraph& graph, const std::vector<Pose2>& poses, MapQuality& quality);

/// Gives the keyframes their poses and covariances (by id), the latter multiplied by the factor,
/// and moves the weak spots with them. Frames follow by PlaceFrames.
void PlaceKeyframes(MapGraph& graph,
                    const std::vector<Pose2>& poses,
                    const std::vector<Eigen::Matrix3d>& covariances,
                    double variance_factor);

}  // namespace ceilmap::graph
