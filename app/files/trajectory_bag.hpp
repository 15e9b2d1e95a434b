#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/bags/mcap_writer.hpp"
#include "app/bags/messages.hpp"
#include "mapping/graph/keyframe.hpp"

namespace ceilmap::files {

/// Topics and frames of a trajectory in a bag (REP-105).
inline constexpr const char* kPoseTopic = "/pose";
inline constexpr const char* kTransformsTopic = "/tf";
inline constexpr const char* kDiagnosticsTopic = "/diagnostics";
/// The name of a diagnostic status; its message is that of graph::ToString(TrackingStatus).
inline constexpr const char* kDiagnosticsName = "ceilmap";
inline constexpr const char* kMapFrame = "map";
inline constexpr const char* kBaseFrame = "base_link";

/// The pose of base in the map, with the tilt.
bags::Transform TransformOf(const graph::FramePose& frame);

/// A trajectory as messages of ROS 2, at the times of the frames: of each frame with a pose a
/// geometry_msgs/PoseWithCovarianceStamped on /pose and the transform map -> base_link on /tf; of
/// every frame a diagnostic_msgs/DiagnosticArray on /diagnostics: OK tracking; WARN ambiguous,
/// relocalized, predicted; ERROR lost.
class TrajectoryBag {
 public:
  /// Names and values of a diagnostic status.
  using Values = std::vector<std::pair<std::string, std::string>>;

  /// @param writer  must outlive this object, which does not commit it.
  explicit TrajectoryBag(bags::McapWriter& writer);

  /// @param with_pose  Its pose is written, not only its status.
  /// @param values  Added to those of the pose.
  /// @throws InputError for a time that ROS cannot express.
  void Add(const graph::FramePose& frame, bool with_pose, const Values& values = {});

 private:
  bags::McapWriter& writer_;
  bags::McapWriter::ChannelId pose_;
  bags::McapWriter::ChannelId transforms_;
  bags::McapWriter::ChannelId diagnostics_;
};

}  // namespace ceilmap::files
