#include "mapping/history_union.hpp"

#include <Eigen/Core>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

namespace ceilmap::mapping {
namespace {

using PosesById = std::unordered_map<std::int64_t, Pose2>;

/// Mean of the corners of a change.
Eigen::Vector2d MiddleOf(const store::Change& change) {
  Eigen::Vector2d sum(0, 0);
  double corners = 0;
  for (const auto& rings : change.polygons) {
    for (const auto& ring : rings) {
      for (const cv::Point2d& p : ring) sum += Eigen::Vector2d(p.x, p.y);
      corners += static_cast<double>(ring.size());
    }
  }
  return corners > 0 ? Eigen::Vector2d(sum / corners) : sum;
}

void Move(store::Change& change, const Pose2& T_new_old) {
  for (auto& rings : change.polygons) {
    for (auto& ring : rings) {
      for (cv::Point2d& p : ring) {
        const Eigen::Vector2d moved = T_new_old * Eigen::Vector2d(p.x, p.y);
        p = {moved.x(), moved.y()};
      }
    }
  }
}

/// How the map has moved where a change is; nothing where no keyframe is left.
std::optional<Pose2> MotionAt(const Eigen::Vector2d& place,
                              const std::vector<graph::Keyframe>& before,
                              const PosesById& after) {
  const Pose2* from = nullptr;
  const Pose2* to = nullptr;
  for (const graph::Keyframe& keyframe : before) {
    const Pose2& T_old_base = keyframe.pose.T_map_base;
    const auto found = after.find(keyframe.id);
    if (found == after.end()) continue;
    if (from != nullptr &&
        (T_old_base.Translation() - place).norm() >= (from->Translation() - place).norm()) {
      continue;
    }
    from = &T_old_base;
    to = &found->second;
  }
  if (from == nullptr) return std::nullopt;
  if (from->x == to->x && from->y == to->y && from->yaw == to->yaw) return Pose2();
  return *to * from->Inverse();
}

/// Takes over what happened in a part, its sessions by their new numbers.
void AddChanges(const PartHistory& part,
                const PosesById& after,
                const std::map<std::int64_t, std::int64_t>& sessions,
                bool renumber,
                store::MapHistory& all) {
  for (store::Change change : part.history.changes) {
    const std::optional<Pose2> motion = MotionAt(MiddleOf(change), part.keyframes, after);
    if (!motion) continue;
    if (motion->x != 0 || motion->y != 0 || motion->yaw != 0) Move(change, *motion);
    if (renumber) {
      const auto number = [&](std::int64_t id) {
        const auto found = sessions.find(id);
        return found == sessions.end() ? id : found->second;
      };
      change.first_session = number(change.first_session);
      change.last_session = number(change.last_session);
      change.id = static_cast<std::int64_t>(all.changes.size()) + 1;
    }
    all.changes.push_back(std::move(change));
  }
}

}  // namespace

store::MapHistory UniteHistories(std::vector<PartHistory> parts, const graph::MapGraph& united) {
  PosesById after;
  for (const graph::Keyframe& keyframe : united.keyframes) {
    after[keyframe.id] = keyframe.pose.T_map_base;
  }
  store::MapHistory all;
  const bool renumber = parts.size() > 1;
  std::vector<std::size_t> next(parts.size(), 0);
  std::vector<std::map<std::int64_t, std::int64_t>> numbers(parts.size());
  for (;;) {
    const store::Session* first = nullptr;
    std::size_t of = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::vector<store::Session>& sessions = parts[i].history.sessions;
      if (next[i] == sessions.size()) continue;
      if (first != nullptr && sessions[next[i]].date >= first->date) continue;
      first = &sessions[next[i]];
      of = i;
    }
    if (first == nullptr) break;
    ++next[of];
    all.sessions.push_back(*first);
    if (renumber) all.sessions.back().id = static_cast<std::int64_t>(all.sessions.size());
    numbers[of][first->id] = all.sessions.back().id;
  }
  for (std::size_t i = 0; i < parts.size(); ++i) {
    AddChanges(parts[i], after, numbers[i], renumber, all);
  }
  return all;
}

}  // namespace ceilmap::mapping
