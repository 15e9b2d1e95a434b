#include "samples/simulator/tum_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "calib/base/error.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;

[[noreturn]] void Fail(const Scene& scene, const Frame& frame, const std::string& what) {
  throw InputError(
      fmt::format("{}: at {:.6f} s {}", scene.path.tum_file.string(), frame.stamp_s, what));
}

template <typename AnyCamera>
void CheckInside(const Scene& scene, const AnyCamera& camera, const Frame& frame) {
  const Eigen::Vector3d p =
      frame.T_map_base * Eigen::Vector3d(camera.mount_x_m, camera.mount_y_m, camera.mount_height_m);
  const Room& room = scene.room;
  const bool inside = p.x() > 0 && p.x() < room.length_m && p.y() > 0 && p.y() < room.width_m &&
                      p.z() > 0 && p.z() < room.height_m;
  if (!inside) {
    Fail(scene,
         frame,
         fmt::format("the camera at ({:.3f}, {:.3f}, {:.3f}) must be inside of the room of {:g} x "
                     "{:g} x {:g} m",
                     p.x(),
                     p.y(),
                     p.z(),
                     room.length_m,
                     room.width_m,
                     room.height_m));
  }
}

/// Interpolates between two poses.
Isometry3d Between(const Isometry3d& T_map_a, const Isometry3d& T_map_b, double fraction) {
  const Eigen::Quaterniond a(T_map_a.linear());
  const Eigen::Quaterniond b(T_map_b.linear());
  Isometry3d T = Isometry3d::Identity();
  T.linear() = a.slerp(fraction, b).toRotationMatrix();
  T.translation() = (1 - fraction) * T_map_a.translation() + fraction * T_map_b.translation();
  return T;
}

/// `offset_s` after frame i, at most half-way to its neighbour.
Isometry3d Near(const std::vector<Frame>& frames, std::size_t i, double offset_s) {
  const std::size_t other = offset_s < 0 ? i - 1 : i + 1;  // underflows at the start
  if (other >= frames.size()) return frames[i].T_map_base;
  const double gap_s = frames[other].stamp_s - frames[i].stamp_s;
  return Between(frames[i].T_map_base, frames[other].T_map_base, std::min(0.5, offset_s / gap_s));
}

}  // namespace

std::vector<Frame> TumFrames(const Scene& scene) {
  if (scene.path.poses.empty()) {
    throw InputError(fmt::format("{}: no poses of it were read", scene.path.tum_file.string()));
  }
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
    CheckInside(scene, scene.camera, frame);
    if (scene.forward) CheckInside(scene, *scene.forward, frame);
    if (scene.omni) CheckInside(scene, *scene.omni, frame);
    if (!frames.empty() && !(frame.stamp_s > frames.back().stamp_s)) {
      Fail(scene, frame, "the timestamp must be later than the one before");
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
