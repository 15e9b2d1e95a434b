#include "compensation/mount/steady_light.hpp"

#include <cmath>
#include <optional>

#include "calib/ceiling_view.hpp"
#include "compensation/flicker_bands.hpp"

namespace ceilmap::mount {
namespace {

/// The levelled camera's pose on the floor: of its planar axes in base.
Pose2 InFloor(const calib::CeilingView& view) {
  const Eigen::Isometry3d& T_base_camera = view.T_base_camera();
  return {T_base_camera.translation().x(),
          T_base_camera.translation().y(),
          std::atan2(T_base_camera.linear()(1, 0), T_base_camera.linear()(0, 0))};
}

}  // namespace

CeilingRecording WithoutFlicker(const CeilingRecording& recording,
                                const std::vector<Pose2>& cameras,
                                const calib::MountedCamera& up,
                                double ceiling_height_m) {
  using compensation::Bands;
  using compensation::FlickerBands;
  // Bands are predicted over a few seconds only.
  constexpr double kReachS = 3;
  if (!recording.has_stamps || !FlickerBands::Visible(up.readout_time_s)) return recording;
  const calib::CeilingView view(up, ceiling_height_m);
  const double distance_m = ceiling_height_m - up.T_base_cam.translation().z();
  const Pose2 T_base_camera = InFloor(view);
  FlickerBands flicker(view, up.readout_time_s);
  std::vector<std::optional<Bands>> found;
  found.reserve(cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CeilingKeyframe& keyframe = recording.keyframes[i];
    const Pose2 T_first_camera{
        distance_m * cameras[i].x, distance_m * cameras[i].y, cameras[i].yaw};
    flicker.Remove(keyframe.image, keyframe.stamp_s);
    flicker.Place(keyframe.stamp_s, T_base_camera * T_first_camera * T_base_camera.Inverse());
    found.push_back(flicker.Found());
  }
  CeilingRecording steady = recording;
  std::optional<Bands> next;
  for (std::size_t i = found.size(); i-- > 0;) {
    CeilingKeyframe& keyframe = steady.keyframes[i];
    if (found[i]) next = found[i];
    if (!next || next->stamp_s - keyframe.stamp_s > kReachS) continue;
    keyframe.image = flicker.Without(*next, keyframe.image, keyframe.stamp_s);
  }
  return steady;
}

}  // namespace ceilmap::mount
