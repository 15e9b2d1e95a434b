#include "mapping/predicted_frames.hpp"

#include <Eigen/Cholesky>
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

/// One pose of two predictions, forwards and backwards in time. Where they contradict each other
/// the wheels have slipped between the frames with poses, at any time: before it the first one is
/// right, after it the second. @param part  of the time that has passed, 0..1.
PoseWithCovariance Between(const PoseWithCovariance& forwards,
                           const PoseWithCovariance& backwards,
                           double part) {
  constexpr double kMaxSigmas = 4;
  const Eigen::Vector3d off(backwards.pose.x - forwards.pose.x,
                            backwards.pose.y - forwards.pose.y,
                            WrapAngle(backwards.pose.yaw - forwards.pose.yaw));
  const Eigen::Matrix3d spread = forwards.covariance + backwards.covariance;
  if (!(off.dot(spread.ldlt().solve(off)) > kMaxSigmas * kMaxSigmas)) {
    return Fused(forwards, backwards);
  }
  PoseWithCovariance between = forwards;
  between.pose.x += part * off.x();
  between.pose.y += part * off.y();
  between.pose.yaw = WrapAngle(between.pose.yaw + part * off.z());
  between.covariance = (1 - part) * forwards.covariance + part * backwards.covariance +
                       part * (1 - part) * off * off.transpose();
  return between;
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
    if (backwards[i]) {
      pose =
          Between(pose, *backwards[i], static_cast<double>(i + 1) / static_cast<double>(count + 1));
    }
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
