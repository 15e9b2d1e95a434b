#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "mapping/graph/map_graph.hpp"

/// Frames of a trajectory relative to the keyframes around them, and their poses after the
/// keyframes have moved. Internal to map_graph.
namespace ceilmap::graph {

using KeyframesById = std::unordered_map<std::int64_t, const Keyframe*>;
KeyframesById ById(const std::vector<Keyframe>& keyframes);

/// A frame relative to its keyframe.
struct Tie {
  Pose2 T_keyframe_frame;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// The pose of each frame relative to its keyframe. Its relative covariance is its own minus that
/// of the keyframe (the inverse of ComposeCovariance).
std::vector<Tie> Ties(const MapGraph& graph);

/// The way from a keyframe to the next one of the same recording, before the graph changes it.
struct Leg {
  Pose2 T_keyframe_next;
  std::int64_t next_id = 0;
  std::int64_t first_frame = 0;  ///< frame indices of the two
  std::int64_t next_frame = 0;
  bool by_wheels = false;  ///< the ceiling does not show all of it
};
using Legs = std::unordered_map<std::int64_t, Leg>;  ///< by keyframe
Legs LegsOf(const MapGraph& graph);
/// The leg of which a frame shares the corrections; nullptr: it moves with its keyframe. What the
/// ceiling shows of a place before a dark stretch says nothing of the way through the dark.
const Leg* LegOf(const Legs& legs, const FramePose& frame);

/// The pose of a frame relative to its keyframe, after the next keyframe has moved: the frames
/// between the two share the correction in proportion to the distance travelled.
/// @param T_keyframe_next  the new one.
Pose2 Stretched(const Pose2& T_keyframe_frame,
                std::int64_t frame_index,
                const Leg& leg,
                const Pose2& T_keyframe_next);

/// Places the frames of a graph whose keyframes have moved. @param ties, legs  of the graph before.
/// @param variance_factor  of the ties' covariances.
void PlaceFrames(MapGraph& graph,
                 const std::vector<Tie>& ties,
                 const Legs& legs,
                 double variance_factor);

}  // namespace ceilmap::graph
