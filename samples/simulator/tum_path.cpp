#include "samples/simulator/tum_path.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "calib/base/error.hpp"
#include "samples/simulator/cameras_inside.hpp"
#include "samples/simulator/pose_interpolation.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;

/// `offset_s` after frame i, at most half-way to its neighbour.
Isometry3d Near(const std::vector<Frame>& frames, std::size_t i, double offset_s) {
  const std::size_t other = offset_s < 0 ? i - 1 : i + 1;  // underflows at the start
  if (other >= frames.size()) return frames[i].T_map_base;
  const double gap_s = frames[other].stamp_s - frames[i].stamp_s;
  return Between(frames[i].T_map_base, frames[other].T_map_base, std::min(0.5, offset_s / gap_s));
}

}  // namespace

void CheckPosesRead(const Path& path) {
  if (!path.poses.empty()) return;
  throw InputError(fmt::format("{}: no poses of it were read", path.tum_file.string()));
}

std::vector<Frame> TumFrames(const Scene& scene) {
  CheckPosesRead(scene.path);
  if (scene.path.poses.size() > static_cast<std::size_t>(kMaxFrames)) {
    throw InputError(fmt::format("{}: holds {} poses, must be at most {}; split it",
                                 scene.path.tum_file.string(),
                                 scene.path.poses.size(),
                                 kMaxFrames));
  }
  std::vector<Frame> frames;
  frames.reserve(scene.path.poses.size());
  for (const PathPose& pose : scene.path.poses) {
    Frame frame;
    frame.index = static_cast<std::int64_t>(frames.size());
    frame.stamp_s = pose.stamp_s;
    frame.T_map_base = pose.T_map_base;
    CheckCamerasInside(scene, frame, scene.path.tum_file.string());
    if (!frames.empty() && !(frame.stamp_s > frames.back().stamp_s)) {
      throw InputError(
          fmt::format("{}: at {:.6f} s the timestamp must be later than the one before",
                      scene.path.tum_file.string(),
                      frame.stamp_s));
    }
    frames.push_back(frame);
  }
  const double half = HalfExposure(scene.camera);
  const double forward_half = scene.forward ? scene.forward->exposure_time_s / 2 : 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].T_map_base_open = Near(frames, i, -half);
    frames[i].T_map_base_close = Near(frames, i, half);
    frames[i].T_map_base_forward_open = Near(frames, i, -forward_half);
    frames[i].T_map_base_forward_close = Near(frames, i, forward_half);
  }
  const auto most = static_cast<std::size_t>(scene.path.max_frames);
  if (most > 0 && frames.size() > most) frames.resize(most);
  return frames;
}

}  // namespace ceilmap::simulator
