#include "samples/simulator/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "calib/base/error.hpp"
#include "samples/simulator/camera_rays.hpp"
#include "samples/simulator/fixtures.hpp"
#include "samples/simulator/image_model.hpp"
#include "samples/simulator/motion_blur.hpp"
#include "samples/simulator/movers.hpp"
#include "samples/simulator/omni_eye.hpp"
#include "samples/simulator/ray_tracer.hpp"
#include "samples/simulator/structures.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::Isometry3d;

const Scene& Checked(const Scene& scene) {
  scene.Validate();
  return scene;
}

/// Half of the size of an upward camera's pixel on the ceiling.
double TexelSize(const Scene& scene) {
  const Camera& camera = scene.camera;
  return (scene.room.height_m - camera.mount_height_m) / camera.focal_px / 2;
}

/// Half of the longer side of a forward camera's pixel on the ceiling where that is nearest: the
/// viewing angle is flat, and finer samples would cause aliasing.
double ForwardTexelSize(const Scene& scene) {
  const Camera& camera = *scene.forward;
  const double half_height = camera.height_px / 2.0 / camera.focal_px;
  const bool fisheye = camera.distortion_model == calib::LensModel::kEquidistant;
  const double half_view = fisheye ? std::min(half_height, 1.4) : std::atan(half_height);
  const double raised = std::abs(camera.mount_pitch_deg) * std::numbers::pi / 180 + half_view;
  const double rise = std::sin(std::clamp(raised, 0.1, std::numbers::pi / 2));
  const double span_rad = std::pow(std::cos(half_view), 2) / camera.focal_px;
  const double height_m = scene.room.height_m - camera.mount_height_m;
  return std::min(0.02, height_m / (rise * rise) * span_rad / 2);
}

constexpr PixelPurposes kUpPixels{Purpose::kPixelGain, Purpose::kPixelNoise};
constexpr PixelPurposes kForwardPixels{Purpose::kForwardGain, Purpose::kForwardNoise};
constexpr std::array kForwardColours{
    // blue, green, red
    PixelPurposes{Purpose::kForwardBlueGain, Purpose::kForwardBlueNoise, -1},
    PixelPurposes{Purpose::kForwardGreenGain, Purpose::kForwardGreenNoise, 0},
    PixelPurposes{Purpose::kForwardRedGain, Purpose::kForwardRedNoise, 1}};

/// The automatic exposure is the upward camera's.
Frame WithoutAutoGain(Frame frame) {
  frame.auto_gain = 1;
  return frame;
}

/// A camera of the robot with everything its images need.
class Eye {
 public:
  Eye(const Scene& scene,
      const Camera& camera,
      const calib::MountedCamera& mounted,
      const std::vector<Solid>& solids,
      double texel_m,
      std::span<const PixelPurposes> pixels)
      : mounted_(mounted),
        rays_(mounted.camera),
        scene_(scene),
        exposure_time_s_(camera.exposure_time_s),
        readout_time_s_(camera.readout_time_s),
        tracer_(scene, solids, texel_m, camera.saturation) {
    for (const PixelPurposes& plane : pixels) planes_.emplace_back(scene, camera, plane);
  }

  [[nodiscard]] cv::Mat Trace(const Isometry3d& T_map_base,
                              const std::vector<PaintedSolid>& movers = {},
                              EdgeQuality edges = EdgeQuality::kFine,
                              cv::Range rows = cv::Range::all()) const {
    return tracer_.Trace(rays_, T_map_base * mounted_.T_base_cam, movers, edges, rows);
  }

  /// @param blur_px  Motion in the image during the exposure of a row.
  [[nodiscard]] cv::Mat Take(const Exposure& exposure, double blur_px, const Frame& frame) const {
    if (readout_time_s_ == 0) {
      return DevelopPlanes(
          planes_, Light(exposure, blur_px, frame, 0, {0, mounted_.camera.height_px}), frame);
    }
    cv::Mat light;
    const int height = mounted_.camera.height_px;
    for (int row = 0; row < height; row += CameraRays::kPartSize) {
      const cv::Range rows(row, std::min(row + CameraRays::kPartSize, height));
      const double middle = (rows.start + rows.end - 1) / 2.0 / (height - 1) - 0.5;
      const cv::Mat now = Light(exposure, blur_px, frame, middle * readout_time_s_, rows);
      if (light.empty()) light.create(now.size(), now.type());
      now.rowRange(rows).copyTo(light.rowRange(rows));
    }
    return DevelopPlanes(planes_, light, frame);
  }

  [[nodiscard]] const calib::MountedCamera& Mounted() const { return mounted_; }

 private:
  /// Mean light during the exposure of rows. @param after_middle_s  of its middle.
  [[nodiscard]] cv::Mat Light(const Exposure& exposure,
                              double blur_px,
                              const Frame& frame,
                              double after_middle_s,
                              cv::Range rows) const {
    const std::vector<double> times = TimesOfBlur(blur_px);
    // The mean of several images has finer edges than each of them.
    const EdgeQuality edges = times.size() > 1 ? EdgeQuality::kCoarse : EdgeQuality::kFine;
    cv::Mat light;
    for (const double time : times) {
      const double shift_s = after_middle_s + time * exposure_time_s_ / 2;
      const cv::Mat now = Trace(
          PoseDuring(exposure, shift_s), MoversAt(scene_, frame.stamp_s, shift_s), edges, rows);
      if (light.empty()) {
        light = now;
      } else {
        light.rowRange(rows) += now.rowRange(rows);
      }
    }
    if (times.size() > 1) light.rowRange(rows) *= 1.0 / static_cast<double>(times.size());
    return light;
  }

  calib::MountedCamera mounted_;
  CameraRays rays_;
  const Scene& scene_;
  double exposure_time_s_;
  double readout_time_s_;
  RayTracer tracer_;
  std::vector<ImageModel> planes_;  // one, or blue, green, red
};

}  // namespace

struct Renderer::Parts {
  explicit Parts(const Scene& valid_scene)
      : scene(valid_scene),
        rig(calib::ParseRig(RigYaml(scene), "rig.yaml")),
        objects(MakeObjects(scene)),
        up(scene,
           scene.camera,
           *rig.up,
           objects.solids,
           TexelSize(scene),
           std::span(&kUpPixels, 1)) {
    if (scene.omni) omni.emplace(scene, objects.solids);
    if (!scene.forward) return;
    const Camera& camera = *scene.forward;
    const std::span<const PixelPurposes> pixels =
        camera.saturation > 0 ? std::span<const PixelPurposes>(kForwardColours)
                              : std::span(&kForwardPixels, 1);
    forward.emplace(scene, camera, *rig.forward, objects.solids, ForwardTexelSize(scene), pixels);
  }

  [[nodiscard]] const Eye& Forward() const {
    if (!forward) {
      throw InputError("the scene has no forward camera; give it the group 'forward'");
    }
    return *forward;
  }

  [[nodiscard]] const OmniEye& Omni() const {
    if (!omni) {
      throw InputError("the scene has no omnidirectional camera; give it the group 'omni'");
    }
    return *omni;
  }

  Scene scene;
  calib::Rig rig;
  Objects objects;
  Eye up;
  std::optional<Eye> forward;
  std::optional<OmniEye> omni;
};

Renderer::Renderer(const Scene& scene) : parts_(std::make_unique<const Parts>(Checked(scene))) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

cv::Mat Renderer::Render(const Frame& frame) const {
  const Eye& up = parts_->up;
  const Camera& camera = parts_->scene.camera;
  const Exposure exposure{
      frame.T_map_base, frame.T_map_base_open, frame.T_map_base_close, HalfExposure(camera)};
  double blur_px = 0;
  if (parts_->scene.image.motion_blur) {
    blur_px =
        BlurLength(up.Mounted(),
                   exposure,
                   PlaneInCorners(up.Mounted(), frame.T_map_base, NearestHeight(parts_->scene)));
    if (camera.readout_time_s != 0) {
      blur_px *= camera.exposure_time_s / 2 / exposure.half_s;  // of one row
    }
    blur_px = std::max(blur_px, MovingBlurLength(parts_->scene, parts_->scene.camera));
  }
  return up.Take(exposure, blur_px, frame);
}

cv::Mat Renderer::RenderForward(const Frame& frame) const {
  const Eye& forward = parts_->Forward();
  const Exposure exposure{frame.T_map_base,
                          frame.T_map_base_forward_open,
                          frame.T_map_base_forward_close,
                          HalfExposure(*parts_->scene.forward)};
  double blur_px = 0;
  if (parts_->scene.image.motion_blur) {
    blur_px = BlurLength(forward.Mounted(),
                         exposure,
                         RoomInImage(forward.Mounted(), frame.T_map_base, parts_->scene.room));
  }
  return forward.Take(exposure, blur_px, WithoutAutoGain(frame));
}

cv::Mat Renderer::RenderOmni(const Frame& frame) const {
  return parts_->Omni().Take(WithoutAutoGain(frame));
}

cv::Mat Renderer::RenderLight(const Isometry3d& T_map_base) const {
  return parts_->up.Trace(T_map_base);
}

cv::Mat Renderer::RenderForwardLight(const Isometry3d& T_map_base) const {
  return parts_->Forward().Trace(T_map_base);
}

cv::Mat Renderer::RenderOmniLight(const Frame& frame) const {
  return parts_->Omni().Light(frame);
}

const Scene& Renderer::GetScene() const {
  return parts_->scene;
}

const calib::Rig& Renderer::GetRig() const {
  return parts_->rig;
}

const Objects& Renderer::GetObjects() const {
  return parts_->objects;
}

}  // namespace ceilmap::simulator
