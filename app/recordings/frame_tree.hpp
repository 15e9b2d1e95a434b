#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/bags/messages.hpp"

namespace ceilmap::recordings {

/// A pose of a message. @return nothing where it is not finite or its quaternion is not of length 1
/// (within 1 %): ROS leaves what is not known at zero.
std::optional<Eigen::Isometry3d> ToIsometry(const bags::Transform& transform);

/// Frame names as ROS 2 writes them: ROS 1 may begin them with a slash.
std::string FrameName(const std::string& frame_id);
/// The name without the namespace of the robot: "base_link" of "robot_1/base_link".
std::string LocalName(const std::string& frame_id);

/// The fixed frames of a robot, by the transforms of /tf_static: each frame has one parent.
class FrameTree {
 public:
  /// A later transform of the same frame replaces it; those that are no pose are ignored.
  void Add(const bags::TransformStamped& transform);

  [[nodiscard]] bool Empty() const { return parents_.empty(); }
  /// T_target_source: p_target = T * p_source, by any chain of transforms.
  /// @return nothing where the two are not connected.
  [[nodiscard]] std::optional<Eigen::Isometry3d> Find(const std::string& target,
                                                      const std::string& source) const;
  /// The frame on the floor under the robot: base_footprint, else base_link, that `source` hangs
  /// on. @return nothing where it hangs on neither.
  [[nodiscard]] std::optional<std::string> BaseOf(const std::string& source) const;

 private:
  struct Parent {
    std::string name;
    Eigen::Isometry3d T_parent_child;
  };
  /// A frame with all above it, and the transforms from `source` to each.
  struct Ancestor {
    std::string name;
    Eigen::Isometry3d T_ancestor_source;
  };
  [[nodiscard]] std::vector<Ancestor> AncestorsOf(const std::string& source) const;

  std::map<std::string, Parent> parents_;  // by the child
};

}  // namespace ceilmap::recordings
