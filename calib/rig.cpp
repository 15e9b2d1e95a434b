#include "calib/rig.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "calib/base/degrees.hpp"
#include "calib/base/yaml_value.hpp"
#include "calib/camera_info.hpp"
#include "calib/mirror_reader.hpp"
#include "calib/mount_reader.hpp"
#include "calib/rig_text.hpp"
#include "calib/rotation_slip.hpp"
#include "calib/wheel_section.hpp"

namespace ceilmap::calib {
namespace {

/// Inline or from a separate camera_info file, never both.
Lens ParseIntrinsics(const YamlValue& value) {
  const auto path = value.Find("camera_info");
  if (!path) return ParseCameraInfo(value);
  for (const char* key : {"image_width",
                          "image_height",
                          "camera_matrix",
                          "distortion_model",
                          "distortion_coefficients",
                          "rectification_matrix",
                          "projection_matrix"}) {
    if (const auto doubled = value.Find(key)) {
      doubled->Fail("given here or in camera_info, not both", "remove one of the two");
    }
  }
  return ReadCameraInfo(value.File().parent_path() / path->Text());
}

/// For a ring only the image size of the camera is needed.
Lens ParseRingIntrinsics(const YamlValue& value) {
  for (const char* key :
       {"camera_info", "camera_matrix", "distortion_model", "distortion_coefficients"}) {
    if (value.Find(key)) return ParseIntrinsics(value);
  }
  return ParseImageSize(value);
}

/// Parses the mirror of a camera of that type; its intrinsics and pose must be known.
void ParseMirrorOf(const YamlValue& value, const std::string& type, MountedCamera& mounted) {
  if (type == "hyperbolic_mirror") {
    mounted.mirror = ParseMirror(value.At("mirror", "mirror: {A: ..., B: ..., C: ..., ...}"),
                                 mounted.T_base_cam);
  } else if (type == "mirror") {
    const Lens& camera = mounted.camera;
    std::optional<Eigen::Vector2d> axis_px;
    if (camera.fx > 0) axis_px = {camera.cx, camera.cy};
    mounted.mirror_ring = ParseMirrorRing(
        value.At("mirror",
                 "mirror: {inner_radius_px: ..., outer_radius_px: ..., centre_px: [u, v]}"),
        camera.Size(),
        axis_px);
  } else if (const auto mirror = value.Find("mirror")) {
    mirror->Fail("absent for type pinhole", "remove it, or write type: hyperbolic_mirror");
  }
}

/// The rotation of a camera for which the file gives none, and what it means.
struct DefaultMount {
  Eigen::Matrix3d R_base_cam;
  std::string_view meaning;
};

DefaultMount DefaultUpMount() {
  Eigen::Matrix3d R;  // x_cam = +y_base, y_cam = -x_base, z_cam = +z_base
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return {R, "it looks straight up, the top of its image is towards the robot's front"};
}

DefaultMount DefaultForwardMount() {
  Eigen::Matrix3d R;  // x_cam = -y_base, y_cam = -z_base, z_cam = +x_base
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {R, "it looks straight ahead, level, the top of its image is up"};
}

ViewChoice ParseViewChoice(const YamlValue& value) {
  value.AllowOnly({"field_of_view_deg", "size"});
  constexpr double kMinDeg = 10;
  constexpr double kMaxDeg = 150;
  constexpr int kMinSizePx = 64;
  constexpr int kMaxSizePx = 8192;
  ViewChoice choice;
  if (const auto angle = value.Find("field_of_view_deg")) {
    const double deg = angle->Number();
    if (!(deg >= kMinDeg && deg <= kMaxDeg)) {
      angle->Fail(fmt::format("{:g} to {:g}", kMinDeg, kMaxDeg),
                  "give the angle across the width of the view");
    }
    choice.field_of_view_rad = deg * kRadPerDeg;
  }
  if (const auto size = value.Find("size")) {
    const std::vector<double> sides = size->Numbers(2);
    for (const double side : sides) {
      if (side != std::floor(side) || side < kMinSizePx || side > kMaxSizePx) {
        size->Fail(fmt::format("two whole numbers from {} to {}", kMinSizePx, kMaxSizePx),
                   "give the width and height of the view in pixels");
      }
    }
    choice.size = cv::Size(static_cast<int>(sides[0]), static_cast<int>(sides[1]));
  }
  return choice;
}

double ParseReadoutTime(const YamlValue& value) {
  constexpr double kMaxSeconds = 0.2;
  const double seconds = value.Number();
  if (!(std::abs(seconds) <= kMaxSeconds)) {
    value.Fail(fmt::format("from -{0:g} to {0:g}", kMaxSeconds),
               "give it in seconds, from the first to the last row; negative: the bottom row is "
               "first");
  }
  return seconds;
}

/// @param key  of the camera, for `assumed`, to which the values are added that are not given.
MountedCamera ParseCamera(const YamlValue& value,
                          const std::string& key,
                          const DefaultMount& mount,
                          std::vector<std::string>& assumed) {
  value.AllowOnly({"type",
                   "camera_info",
                   "image_width",
                   "image_height",
                   "camera_name",
                   "camera_matrix",
                   "distortion_model",
                   "distortion_coefficients",
                   "rectification_matrix",
                   "projection_matrix",
                   "base_link_to_camera",
                   "exposure_time",
                   "readout_time_s",
                   "view",
                   "mirror"});
  const YamlValue type = value.At("type", "type: pinhole, hyperbolic_mirror or mirror");
  const std::string name = type.Text();
  if (name != "pinhole" && name != "hyperbolic_mirror" && name != "mirror") {
    type.Fail("pinhole, hyperbolic_mirror or mirror", "correct it");
  }
  MountedCamera mounted;
  mounted.camera = name == "mirror" ? ParseRingIntrinsics(value) : ParseIntrinsics(value);
  const YamlValue pose =
      value.At("base_link_to_camera", "base_link_to_camera with translation and rotation_xyzw");
  mounted.T_base_cam = ParseCameraPose(pose, mount.R_base_cam);
  if (!pose.Find("matrix") && !pose.Find("rotation_xyzw")) {
    assumed.push_back(fmt::format("{}: {}", key, mount.meaning));
  }
  if (mounted.camera.fx > 0 && !value.Find("camera_info") && !value.Find("distortion_model")) {
    assumed.push_back(key + ": a lens without distortion");
  }
  if (mounted.T_base_cam.translation().z() < 0) {
    pose.Fail("a pose on or above the floor (z >= 0)",
              "measure z from the floor upwards, and give the pose of the camera in base "
              "(p_base = R p_cam + t), not its inverse");
  }
  if (const auto exposure = value.Find("exposure_time")) {
    mounted.exposure_time_s = exposure->Number();
    if (mounted.exposure_time_s < 0) exposure->Fail(">= 0", "give it in seconds, or 0");
  }
  if (const auto readout = value.Find("readout_time_s")) {
    if (key != "cameras.up") {
      readout->Fail("absent for this camera", "only the upward camera has it");
    }
    mounted.readout_time_s = ParseReadoutTime(*readout);
  }
  if (const auto view = value.Find("view")) {
    if (key != "cameras.up") view->Fail("absent for this camera", "only the upward camera has it");
    mounted.view = ParseViewChoice(*view);
  }
  ParseMirrorOf(value, name, mounted);
  return mounted;
}

/// The upward camera must be below the ceiling and point at it.
void CheckUpwardCamera(const YamlValue& rig, const YamlValue& up, const Rig& result) {
  const MountedCamera& camera = *result.up;
  if (camera.mirror || camera.mirror_ring) {
    up.At("type", "").Fail("pinhole for the upward camera", "name a mirror camera omni");
  }
  if (!PointsUp(camera.T_base_cam.linear())) {
    std::string slip = RotationSlip(camera.T_base_cam.linear(), PointsUp);
    constexpr double kAhead = 0.9;  // cosine
    if (slip.empty() && camera.T_base_cam.linear()(0, 2) > kAhead) {
      slip = "it points ahead: is it the forward camera?";
    }
    up.At("base_link_to_camera", "")
        .Fail("a pose whose optical axis points upwards (within 45 deg)",
              slip.empty() ? "check its signs: p_base = R p_cam + t, z_cam along the view" : slip);
  }
  if (!(result.ceiling_height_m > camera.T_base_cam.translation().z())) {
    rig.At("h", "").Fail(
        "above the upward camera (z = " + std::to_string(camera.T_base_cam.translation().z()) + ")",
        "measure both from the floor, in metres");
  }
}

void ParseCameras(const YamlValue& rig, Rig& result) {
  const YamlValue cameras = rig.At("cameras", "cameras: with up, forward or omni below it");
  cameras.AllowOnly({"up", "forward", "omni"});
  const auto read = [&](const std::string& name,
                        const DefaultMount& mount,
                        std::optional<MountedCamera>& camera) {
    const auto value = cameras.Find(name);
    if (value) camera = ParseCamera(*value, "cameras." + name, mount, result.assumed);
  };
  read("up", DefaultUpMount(), result.up);
  read("forward", DefaultForwardMount(), result.forward);
  read("omni", DefaultUpMount(), result.omni);
  if (!result.up && !result.forward && !result.omni) {
    cameras.Fail("at least one of up, forward, omni", "describe the robot's camera there");
  }
  if (result.up) CheckUpwardCamera(rig, cameras.At("up", ""), result);
}

}  // namespace

Rig ParseRig(const std::string& text, const std::filesystem::path& file) {
  const YamlValue rig = YamlValue::Parse(text, file, kRigFile);
  rig.AllowOnly({"robot", "a", "d", "h", "frames", "cameras", "wheels"});
  Rig result;
  result.file = file;
  result.source_yaml = text;
  if (const auto robot = rig.Find("robot")) result.robot = robot->Text();
  if (const auto a = rig.Find("a")) {
    result.axle_behind_mast_m = a->Number();
  } else {
    result.assumed.emplace_back("a = 0: the axle of the driven wheels is below the camera mast");
  }
  if (const auto d = rig.Find("d")) {
    result.forward_height_m = d->PositiveNumber("measure it from the floor upwards, in metres");
  }
  result.ceiling_height_m =
      rig.At("h", "the ceiling's height above the floor in metres, e.g. h: 2.6")
          .PositiveNumber("measure it from the floor upwards, in metres");
  if (const auto wheels = rig.Find("wheels")) result.wheels = ParseWheels(*wheels);
  ParseCameras(rig, result);
  return result;
}

Rig ReadRig(const std::filesystem::path& file) {
  return ParseRig(ReadSettingsText(file, kRigFile), file);
}

}  // namespace ceilmap::calib
