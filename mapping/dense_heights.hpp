#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "calib/ceiling_view.hpp"
#include "mapping/graph/map_graph.hpp"

namespace ceilmap::mapping {

/// Measures the heights of all keyframes with depth by dense stereo with their neighbours
/// (heights::MeasureByStereo). For final poses: an error of the distance of two keyframes is one of
/// the heights. Keyframes that have such heights already, and those without a usable neighbour,
/// keep what they have.
///
/// @param load  image of a keyframe. Called by one thread at a time.
/// @param threads  0: as many as the machine has cores.
void MeasureDenseHeights(const calib::CeilingView& view,
                         const std::function<cv::Mat(std::int64_t keyframe_id)>& load,
                         int threads,
                         graph::MapGraph& graph);

}  // namespace ceilmap::mapping
