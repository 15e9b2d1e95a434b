#include "samples/simulator/path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/base/error.hpp"
#include "samples/simulator/cameras_inside.hpp"
#include "samples/simulator/drive.hpp"
#include "samples/simulator/motion.hpp"
#include "samples/simulator/path_points.hpp"
#include "samples/simulator/tum_path.hpp"

namespace ceilmap::simulator {
namespace {

std::vector<Frame> PlannedFrames(const Scene& scene) {
  const Path& path = scene.path;
  const double duration_s = Drive(PathPoints(scene), path).Duration();
  double count = std::ceil(duration_s * path.frame_rate_hz - 1e-9) + 1;
  if (path.max_frames > 0) count = std::min(count, static_cast<double>(path.max_frames));
  if (!(count <= static_cast<double>(kMaxFrames))) {
    throw InputError(
        fmt::format("the path takes {:.0f} frames, must be at most {}; shorten it or lower "
                    "path.frame_rate_hz",
                    count,
                    kMaxFrames));
  }
  const Motion motion(scene);
  const auto pose_at = [&](double t) { return motion.BaseAt(t); };
  const double half = HalfExposure(scene.camera);
  const double forward_half = scene.forward ? scene.forward->exposure_time_s / 2 : 0;
  std::vector<Frame> frames;
  frames.reserve(static_cast<std::size_t>(count));
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(count); ++i) {
    const double t = static_cast<double>(i) / path.frame_rate_hz;
    frames.push_back({i,
                      path.start_stamp_s + t,
                      pose_at(t),
                      pose_at(t - half),
                      pose_at(t + half),
                      pose_at(t - forward_half),
                      pose_at(t + forward_half)});
  }
  return frames;
}

/// Moves the frames from the path to map. A frame belongs to one place: during its exposure the
/// robot is not carried away.
void Carry(const Scene& scene, std::vector<Frame>& frames) {
  if (scene.path.carried.empty()) return;
  const Motion motion(scene);
  for (Frame& frame : frames) {
    const auto T_map_path = motion.CarriedAt(frame.stamp_s - StartStamp(scene));
    if (!T_map_path) continue;
    for (Eigen::Isometry3d* pose : {&frame.T_map_base,
                                    &frame.T_map_base_open,
                                    &frame.T_map_base_close,
                                    &frame.T_map_base_forward_open,
                                    &frame.T_map_base_forward_close}) {
      *pose = *T_map_path * *pose;
    }
    CheckCamerasInside(scene, frame, "path.carried");
  }
}

}  // namespace

Frame StillFrame(std::int64_t index, const Pose2& T_map_base, double stamp_s) {
  const Eigen::Isometry3d pose = OnFloor(T_map_base);
  return {index, stamp_s, pose, pose, pose, pose, pose};
}

double PathLength(const Scene& scene) {
  if (scene.path.kind == PathKind::kTum) return 0;
  const Drive drive(PathPoints(scene), scene.path);
  return drive.DistanceAt(drive.Duration());
}

std::vector<Frame> MakePath(const Scene& scene) {
  scene.Validate();
  std::vector<Frame> frames =
      scene.path.kind == PathKind::kTum ? TumFrames(scene) : PlannedFrames(scene);
  Carry(scene, frames);
  return frames;
}

}  // namespace ceilmap::simulator
