#include "app/recordings/frame_tree.hpp"

#include <algorithm>
#include <cmath>

namespace ceilmap::recordings {

std::optional<Eigen::Isometry3d> ToIsometry(const bags::Transform& transform) {
  constexpr double kTolerance = 0.01;
  const auto& [x, y, z] = transform.translation;
  const auto& [qx, qy, qz, qw] = transform.rotation;
  const Eigen::Vector3d translation(x, y, z);
  const Eigen::Quaterniond rotation(qw, qx, qy, qz);
  if (!translation.allFinite() || !(std::abs(rotation.norm() - 1) < kTolerance)) {
    return std::nullopt;
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation.normalized().toRotationMatrix();
  pose.translation() = translation;
  return pose;
}

std::string FrameName(const std::string& frame_id) {
  return frame_id.starts_with('/') ? frame_id.substr(1) : frame_id;
}

std::string LocalName(const std::string& frame_id) {
  return frame_id.substr(frame_id.rfind('/') + 1);  // npos + 1 is 0
}

void FrameTree::Add(const bags::TransformStamped& transform) {
  const std::optional<Eigen::Isometry3d> pose = ToIsometry(transform.transform);
  if (!pose) return;
  parents_[FrameName(transform.child_frame_id)] = {FrameName(transform.header.frame_id), *pose};
}

std::vector<FrameTree::Ancestor> FrameTree::AncestorsOf(const std::string& source) const {
  std::vector<Ancestor> ancestors{{FrameName(source), Eigen::Isometry3d::Identity()}};
  // A file may contain a loop.
  while (ancestors.size() <= parents_.size()) {
    const auto parent = parents_.find(ancestors.back().name);
    if (parent == parents_.end()) break;
    ancestors.push_back(
        {parent->second.name, parent->second.T_parent_child * ancestors.back().T_ancestor_source});
  }
  return ancestors;
}

std::optional<Eigen::Isometry3d> FrameTree::Find(const std::string& target,
                                                 const std::string& source) const {
  const std::vector<Ancestor> of_target = AncestorsOf(target);
  for (const Ancestor& common : AncestorsOf(source)) {
    for (const Ancestor& other : of_target) {
      if (other.name != common.name) continue;
      return other.T_ancestor_source.inverse() * common.T_ancestor_source;
    }
  }
  return std::nullopt;
}

std::optional<std::string> FrameTree::BaseOf(const std::string& source) const {
  std::optional<std::string> base;
  for (const Ancestor& ancestor : AncestorsOf(source)) {
    const std::string name = LocalName(ancestor.name);
    if (name == "base_footprint") return ancestor.name;
    if (name == "base_link") base = ancestor.name;
  }
  // Some robots have the footprint below base_link.
  for (const auto& [child, parent] : parents_) {
    if (base && LocalName(child) == "base_footprint" && Find(*base, child)) return child;
  }
  return base;
}

}  // namespace ceilmap::recordings
