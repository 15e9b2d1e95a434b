#include "samples/simulator/tum_path.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "calib/error.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;

[[noreturn]] void Fail(const Scene& scene, int line, const std::string& what) {
  throw calib::InputError(fmt::format("{}:{}: {}", scene.path.tum_file.string(), line, what));
}

Frame ParseLine(const Scene& scene, int line, const std::string& text) {
  std::istringstream stream(text);
  std::array<double, 8> n{};
  std::string rest;
  for (double& number : n) stream >> number;
  if (!stream || stream >> rest) {
    Fail(scene, line, "must be 8 numbers: timestamp tx ty tz qx qy qz qw");
  }
  const Eigen::Quaterniond rotation(n[7], n[4], n[5], n[6]);
  if (!(std::abs(rotation.norm() - 1) < 1e-3)) {
    Fail(scene, line, "the quaternion must have length 1");
  }
  Frame frame;
  frame.stamp_s = n[0];
  frame.T_map_base.linear() = rotation.normalized().toRotationMatrix();
  frame.T_map_base.translation() = Eigen::Vector3d(n[1], n[2], n[3]);
  return frame;
}

template <typename AnyCamera>
void CheckInside(const Scene& scene, const AnyCamera& camera, int line, const Frame& frame) {
  const Eigen::Vector3d p =
      frame.T_map_base * Eigen::Vector3d(camera.mount_x_m, camera.mount_y_m, camera.mount_height_m);
  const Room& room = scene.room;
  const bool inside = p.x() > 0 && p.x() < room.length_m && p.y() > 0 && p.y() < room.width_m &&
                      p.z() > 0 && p.z() < room.height_m;
  if (!inside) {
    Fail(scene,
         line,
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

/// Part way from one pose to the other.
Isometry3d Between(const Isometry3d& T_map_a, const Isometry3d& T_map_b, double part) {
  const Eigen::Quaterniond a(T_map_a.linear());
  const Eigen::Quaterniond b(T_map_b.linear());
  Isometry3d T = Isometry3d::Identity();
  T.linear() = a.slerp(part, b).toRotationMatrix();
  T.translation() = (1 - part) * T_map_a.translation() + part * T_map_b.translation();
  return T;
}

/// `offset_s` after frame i, at most half-way to its neighbour.
Isometry3d Near(const std::vector<Frame>& frames, std::size_t i, double offset_s) {
  const std::size_t other = offset_s < 0 ? i - 1 : i + 1;  // wraps to a huge number at the start
  if (other >= frames.size()) return frames[i].T_map_base;
  const double gap_s = frames[other].stamp_s - frames[i].stamp_s;
  return Between(frames[i].T_map_base, frames[other].T_map_base, std::min(0.5, offset_s / gap_s));
}

}  // namespace

std::vector<Frame> TumFrames(const Scene& scene) {
  std::ifstream stream(scene.path.tum_file);
  if (!stream) {
    throw calib::InputError(
        fmt::format("{}: cannot be opened; correct path.tum_file", scene.path.tum_file.string()));
  }
  std::vector<Frame> frames;
  std::string text;
  for (int line = 1; std::getline(stream, text); ++line) {
    const std::size_t start = text.find_first_not_of(" \t\r");
    if (start == std::string::npos || text[start] == '#') continue;
    Frame frame = ParseLine(scene, line, text);
    CheckInside(scene, scene.camera, line, frame);
    if (scene.forward) CheckInside(scene, *scene.forward, line, frame);
    if (scene.omni) CheckInside(scene, *scene.omni, line, frame);
    if (!frames.empty() && !(frame.stamp_s > frames.back().stamp_s)) {
      Fail(scene, line, "the timestamp must be later than the one before");
    }
    frame.index = static_cast<std::int64_t>(frames.size());
    frames.push_back(frame);
  }
  if (frames.empty()) {
    throw calib::InputError(fmt::format("{}: holds no poses", scene.path.tum_file.string()));
  }
  const double half = scene.camera.exposure_time_s / 2;
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
