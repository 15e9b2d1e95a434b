#include "app/commands/map_trajectories.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "calib/level_view.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

// Adds frames to others. Both are in order of time, as is the result.
void MergeFrames(const std::vector<graph::FramePose>& added,
                 std::vector<graph::FramePose>& frames) {
  const auto middle = frames.insert(frames.end(), added.begin(), added.end());
  std::inplace_merge(frames.begin(), middle, frames.end(), [](const auto& a, const auto& b) {
    return a.frame_index < b.frame_index;
  });
}

// A frame that was followed, but whose part of the recording did not join the map, is lost.
std::vector<graph::FramePose> UnplacedFrames(const std::vector<graph::FramePose>& noted,
                                             const std::vector<graph::FramePose>& placed) {
  std::set<std::int64_t> on_map;
  for (const graph::FramePose& frame : placed) on_map.insert(frame.frame_index);
  std::vector<graph::FramePose> unplaced;
  for (const graph::FramePose& frame : noted) {
    if (on_map.count(frame.frame_index) != 0) continue;
    unplaced.push_back(frame);
    if (frame.status != graph::TrackingStatus::kAmbiguous) {
      unplaced.back().status = graph::TrackingStatus::kLost;
    }
  }
  return unplaced;
}

}  // namespace

std::vector<graph::FramePose> PlacedFrames(const mapping::MappingResult& map) {
  std::vector<graph::FramePose> frames = map.frames;
  MergeFrames(map.predicted, frames);
  return frames;
}

MapTrajectories::MapTrajectories(const fs::path& trajectory,
                                 const fs::path& uncompensated,
                                 bool predicted)
    : trajectory_(trajectory, predicted), uncompensated_(uncompensated, predicted) {}

void MapTrajectories::Note(const robot::Estimate& estimate) {
  if (!trajectory_.IsBag() && !uncompensated_.IsBag()) return;
  trajectory_.CheckStamp(estimate.stamp_s);
  uncompensated_.CheckStamp(estimate.stamp_s);
  noted_.push_back(robot::ToFramePose(estimate));
}

void MapTrajectories::Write(const mapping::MappingResult& map, const calib::CeilingView& view) {
  std::vector<graph::FramePose> frames = PlacedFrames(map);
  MergeFrames(UnplacedFrames(noted_, frames), frames);
  // Without a rig there is no tilt: both trajectories are the same.
  std::optional<calib::LevelView> level;
  if (view.FocalLength() > 0) level.emplace(view);
  for (graph::FramePose& frame : frames) {
    trajectory_.Add(frame);
    if (level) frame.T_map_base = level->Uncompensated(frame.T_map_base, frame.tilt);
    frame.tilt = {};
    uncompensated_.Add(frame);
  }
  trajectory_.Close();
  uncompensated_.Close();
}

void MapTrajectories::Commit(terminal::Summary& summary) {
  for (files::TrajectoryFile* file : {&trajectory_, &uncompensated_}) {
    if (file->Target().empty()) continue;
    file->Commit();
    summary.files.push_back(file->Target());
  }
}

}  // namespace ceilmap::commands
