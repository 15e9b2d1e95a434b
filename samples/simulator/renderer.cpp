#include "samples/simulator/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "samples/simulator/camera_rays.hpp"
#include "samples/simulator/fixtures.hpp"
#include "samples/simulator/picture_model.hpp"
#include "samples/simulator/ray_tracer.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Scene& Checked(const Scene& scene) {
  scene.Validate();
  return scene;
}

/// Half of what a pixel of the upward camera spans on the ceiling.
double TexelSize(const Scene& scene) {
  const Camera& camera = scene.camera;
  return (scene.room.height_m - camera.mount_height_m) / camera.focal_px / 2;
}

/// Part way from one pose to another one nearby.
Isometry3d Between(const Isometry3d& T_map_a, const Isometry3d& T_map_b, double part) {
  const Eigen::Quaterniond a(T_map_a.linear());
  Isometry3d T = Isometry3d::Identity();
  T.linear() = a.slerp(part, Eigen::Quaterniond(T_map_b.linear())).toRotationMatrix();
  T.translation() = (1 - part) * T_map_a.translation() + part * T_map_b.translation();
  return T;
}

/// When a share `time` in [-1, 1] of the half exposure before or after its middle has passed.
Isometry3d During(const Frame& frame, double time) {
  return time < 0 ? Between(frame.T_map_base, frame.T_map_base_open, -time)
                  : Between(frame.T_map_base, frame.T_map_base_close, time);
}

/// Largest way in pixels that the ceiling moves in the picture during the exposure.
double BlurLength(const calib::Rig& rig, const Frame& frame) {
  const calib::MountedCamera& up = *rig.up;
  const calib::PinholeCamera& camera = up.camera;
  const double right = camera.width_px - 1;
  const double low = camera.height_px - 1;
  const std::array<Vector2d, 4> corners{
      Vector2d(0, 0), Vector2d(right, 0), Vector2d(0, low), Vector2d(right, low)};
  const Isometry3d T_map_cam = frame.T_map_base * up.T_base_cam;
  double longest = 0;
  for (const Vector2d& corner : corners) {
    const double rise = rig.ceiling_height_m - T_map_cam.translation().z();
    const Vector3d p_map = T_map_cam * (rise * Vector3d((corner.x() - camera.cx) / camera.fx,
                                                        (corner.y() - camera.cy) / camera.fy,
                                                        1));
    const auto seen_from = [&](const Isometry3d& T_map_base) {
      const Vector3d p = (T_map_base * up.T_base_cam).inverse() * p_map;
      return Vector2d(camera.fx * p.x() / p.z(), camera.fy * p.y() / p.z());
    };
    longest = std::max(
        longest, (seen_from(frame.T_map_base_close) - seen_from(frame.T_map_base_open)).norm());
  }
  return longest;
}

/// Moments of the exposure, in [-1, 1], whose mean picture has the blur of the whole.
std::vector<double> Moments(double blur_px) {
  if (!(blur_px > 0.1)) return {0};
  // Two pictures at Gauss's points spread as much as the whole way does, and look like it while
  // they are nearer to each other than a pixel.
  if (blur_px < 1.5) return {-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)};
  const int count = std::clamp(static_cast<int>(std::ceil(blur_px / 0.75)), 3, 64);
  std::vector<double> moments(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) moments[i] = (2.0 * i + 1) / count - 1;
  return moments;
}

}  // namespace

struct Renderer::Parts {
  explicit Parts(const Scene& valid_scene)
      : scene(valid_scene),
        rig(calib::ParseRig(RigYaml(scene), "rig.yaml")),
        rays(rig.up->camera),
        tracer(scene, MakeFixtures(scene), TexelSize(scene)),
        picture(scene) {}

  [[nodiscard]] cv::Mat Trace(const Isometry3d& T_map_base) const {
    return tracer.Trace(rays, T_map_base * rig.up->T_base_cam);
  }

  Scene scene;
  calib::Rig rig;
  CameraRays rays;
  RayTracer tracer;
  PictureModel picture;
};

Renderer::Renderer(const Scene& scene) : parts_(std::make_unique<const Parts>(Checked(scene))) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

cv::Mat Renderer::Render(const Frame& frame) const {
  const double blur_px = parts_->scene.picture.motion_blur ? BlurLength(parts_->rig, frame) : 0;
  const std::vector<double> moments = Moments(blur_px);
  cv::Mat light;
  for (const double moment : moments) {
    const cv::Mat now = parts_->Trace(During(frame, moment));
    if (light.empty()) {
      light = now;
    } else {
      light += now;
    }
  }
  if (moments.size() > 1) light *= 1.0 / static_cast<double>(moments.size());
  return parts_->picture.Develop(light, frame);
}

cv::Mat Renderer::RenderLight(const Isometry3d& T_map_base) const {
  return parts_->Trace(T_map_base);
}

const Scene& Renderer::GetScene() const {
  return parts_->scene;
}

const calib::Rig& Renderer::GetRig() const {
  return parts_->rig;
}

const std::vector<Box>& Renderer::Boxes() const {
  return parts_->tracer.Boxes();
}

}  // namespace ceilmap::simulator
