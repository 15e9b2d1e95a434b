#include "mapping/predicted_frames.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ceilmap::mapping {

namespace {

const graph::FramePose* Find(const std::vector<graph::FramePose>& trajectory, std::int64_t index) {
  const auto found = std::lower_bound(
      trajectory.begin(), trajectory.end(), index, [](const graph::FramePose& frame, auto at) {
        return frame.frame_index < at;
      });
  return found != trajectory.end() && found->frame_index == index ? &*found : nullptr;
}

}  // namespace

void PredictedFrames::Add(const graph::FramePose& frame, const wheels::RelativeMotion& step) {
  if (!open_) return;
  Run& run = runs_.back();
  run.frames.push_back(frame);
  run.steps.push_back(step);
}

void PredictedFrames::Interrupt(const graph::FramePose& frame, const wheels::RelativeMotion* step) {
  if (open_ && runs_.back().frames.size() > 1) {
    Run& run = runs_.back();
    run.frames.push_back(frame);
    if (step != nullptr) run.steps.push_back(*step);
  } else if (!runs_.empty() && runs_.back().frames.size() < 2) {
    runs_.pop_back();
  }
  open_ = graph::HasPose(frame.status);
  if (open_) runs_.push_back({{frame}, {}});
}

/// The first frame of a run has a pose. Where there is a step more than frames between, the last
/// one has one too.
void PredictedFrames::PlaceRun(const Run& run,
                               const std::vector<graph::FramePose>& trajectory,
                               std::vector<graph::FramePose>& placed) {
  const graph::FramePose* const before = Find(trajectory, run.frames.front().frame_index);
  if (before == nullptr) return;
  const bool ended =
      run.steps.size() + 1 == run.frames.size() && graph::HasPose(run.frames.back().status);
  const graph::FramePose* const after =
      ended ? Find(trajectory, run.frames.back().frame_index) : nullptr;
  const std::size_t count = std::min(run.steps.size(), run.frames.size() - (ended ? 2 : 1));
  std::vector<std::optional<PoseWithCovariance>> backwards(count);
  if (after != nullptr) {
    wheels::RelativeMotion rest = run.steps.back();
    for (std::size_t i = count; i-- > 0;) {
      backwards[i] = rest.Back({after->T_map_base, after->covariance});
      rest = run.steps[i] * rest;
    }
  }
  wheels::RelativeMotion way;
  for (std::size_t i = 0; i < count; ++i) {
    way = way * run.steps[i];
    PoseWithCovariance pose = way.From({before->T_map_base, before->covariance});
    if (backwards[i]) pose = Fused(pose, *backwards[i]);
    if (!wheels::IsUsable(pose)) continue;
    graph::FramePose frame = run.frames[i + 1];
    frame.status = graph::TrackingStatus::kPredicted;
    frame.T_map_base = pose.pose;
    frame.covariance = pose.covariance;
    frame.keyframe_id = before->keyframe_id;
    placed.push_back(frame);
  }
}

std::vector<graph::FramePose> PredictedFrames::Place(
    const std::vector<graph::FramePose>& trajectory) const {
  std::vector<graph::FramePose> placed;
  for (const Run& run : runs_) {
    if (run.frames.size() > 1) PlaceRun(run, trajectory, placed);
  }
  return placed;
}

}  // namespace ceilmap::mapping
