#include "mapping/history_union.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <map>
#include <opencv2/imgproc.hpp>
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

PosesById ById(const std::vector<graph::Keyframe>& keyframes) {
  PosesById poses;
  for (const graph::Keyframe& keyframe : keyframes) poses[keyframe.id] = keyframe.pose.T_map_base;
  return poses;
}

/// The centre of a pixel of a mosaic.
Eigen::Vector2d CentreOf(const store::MosaicGrid& grid, double col, double row) {
  return {grid.min_x + (col + 0.5) * grid.resolution, grid.max_y - (row + 0.5) * grid.resolution};
}

/// Draws what a look shows into a tile of another mosaic.
/// @param T_old_new  p_old = T_old_new * p_new
void DrawLook(const store::Look& look,
              const store::MosaicGrid& from,
              const store::MosaicGrid& to,
              const Pose2& T_old_new,
              store::Look& tile) {
  const auto in_look = [&](double col, double row) {
    const Eigen::Vector2d p =
        T_old_new * CentreOf(to, tile.origin_px.x + col, tile.origin_px.y + row);
    return cv::Point2d((p.x() - from.min_x) / from.resolution - 0.5 - look.origin_px.x,
                       (from.max_y - p.y()) / from.resolution - 0.5 - look.origin_px.y);
  };
  const cv::Point2d origin = in_look(0, 0);
  const cv::Point2d across = in_look(1, 0) - origin;
  const cv::Point2d down = in_look(0, 1) - origin;
  const cv::Matx23d affine(across.x, down.x, origin.x, across.y, down.y, origin.y);
  cv::Mat drawn;
  cv::Mat whole;  // 255 where all pixels that were mixed have a look
  const int flags = cv::INTER_LINEAR | cv::WARP_INVERSE_MAP;
  cv::warpAffine(look.image, drawn, affine, tile.image.size(), flags);
  cv::warpAffine(look.image > 0, whole, affine, tile.image.size(), flags);
  drawn.copyTo(tile.image, whole == 255);
  tile.session = std::max(tile.session, look.session);
}

}  // namespace

std::vector<store::Look> MoveLooks(const std::vector<store::Look>& looks,
                                   const DrawnMap& before,
                                   const DrawnMap& after) {
  constexpr int kSize = store::Look::kSizePx;
  const PosesById poses = ById(after.keyframes);
  store::LookSquares tiles;
  for (const store::Look& look : looks) {
    const Eigen::Vector2d middle =
        CentreOf(before.grid, look.origin_px.x + kSize / 2.0, look.origin_px.y + kSize / 2.0);
    const std::optional<Pose2> motion = MotionAt(middle, before.keyframes, poses);
    if (!motion) continue;
    cv::Rect2d box;  // of the new mosaic
    for (const cv::Point corner : {cv::Point(0, 0), {kSize, 0}, {0, kSize}, {kSize, kSize}}) {
      const cv::Point of_old = look.origin_px + corner;
      const Eigen::Vector2d p = *motion * CentreOf(before.grid, of_old.x, of_old.y);
      const cv::Rect2d at((p.x() - after.grid.min_x) / after.grid.resolution - 1,
                          (after.grid.max_y - p.y()) / after.grid.resolution - 1,
                          2,
                          2);
      box = box.empty() ? at : box | at;
    }
    box &= cv::Rect2d(0, 0, after.grid.width_px, after.grid.height_px);
    if (box.empty()) continue;
    for (int row = cvFloor(box.y / kSize); row * kSize < box.br().y; ++row) {
      for (int col = cvFloor(box.x / kSize); col * kSize < box.br().x; ++col) {
        store::Look& tile = tiles[{row, col}];
        if (tile.image.empty()) {
          tile.origin_px = {col * kSize, row * kSize};
          tile.image = cv::Mat(kSize, kSize, CV_8UC1, cv::Scalar(0));
        }
        DrawLook(look, before.grid, after.grid, motion->Inverse(), tile);
      }
    }
  }
  return store::NumberedLooks(std::move(tiles));
}

store::MapHistory UniteHistories(std::vector<PartHistory> parts, const graph::MapGraph& united) {
  const PosesById after = ById(united.keyframes);
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
