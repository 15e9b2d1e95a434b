#include "calib/rig.hpp"

#include <cmath>
#include <numbers>

#include "calib/base/yaml_value.hpp"
#include "calib/camera_info.hpp"
#include "calib/mirror_reader.hpp"
#include "calib/mount_reader.hpp"
#include "calib/rig_text.hpp"

namespace ceilmap::calib {
namespace {

/// Inline or from a separate camera_info file, never both.
PinholeCamera ParseIntrinsics(const YamlValue& value) {
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
PinholeCamera ParseRingIntrinsics(const YamlValue& value) {
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
    const PinholeCamera& camera = mounted.camera;
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

MountedCamera ParseCamera(const YamlValue& value) {
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
  mounted.T_base_cam = ParseCameraPose(pose);
  if (mounted.T_base_cam.translation().z() < 0) {
    pose.Fail("a pose on or above the floor (z >= 0)", "measure z from the floor upwards");
  }
  if (const auto exposure = value.Find("exposure_time")) {
    mounted.exposure_time_s = exposure->Number();
    if (mounted.exposure_time_s < 0) exposure->Fail(">= 0", "give it in seconds, or 0");
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
  const double up_cosine = camera.T_base_cam.linear()(2, 2);
  if (!(up_cosine > std::numbers::sqrt2 / 2)) {
    up.At("base_link_to_camera", "")
        .Fail("a pose whose optical axis points upwards (within 45 deg)",
              "check its signs: p_base = R p_cam + t, z_cam along the view");
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
  const auto read = [&](const char* name, std::optional<MountedCamera>& camera) {
    if (const auto value = cameras.Find(name)) camera = ParseCamera(*value);
  };
  read("up", result.up);
  read("forward", result.forward);
  read("omni", result.omni);
  if (!result.up && !result.forward && !result.omni) {
    cameras.Fail("at least one of up, forward, omni", "describe the robot's camera there");
  }
  if (result.up) CheckUpwardCamera(rig, cameras.At("up", ""), result);
}

}  // namespace

Rig ParseRig(const std::string& text, const std::filesystem::path& file) {
  const YamlValue rig = YamlValue::Parse(text, file, kRigFile);
  rig.AllowOnly({"robot", "a", "d", "h", "frames", "cameras"});
  Rig result;
  result.file = file;
  result.source_yaml = text;
  if (const auto robot = rig.Find("robot")) result.robot = robot->Text();
  result.axle_behind_mast_m =
      rig.At("a", "the distance of the axle behind the mast in metres, e.g. a: 0.14").Number();
  if (const auto d = rig.Find("d")) {
    result.forward_height_m = d->PositiveNumber("measure it from the floor upwards, in metres");
  }
  result.ceiling_height_m =
      rig.At("h", "the ceiling's height above the floor in metres, e.g. h: 2.6")
          .PositiveNumber("measure it from the floor upwards, in metres");
  ParseCameras(rig, result);
  return result;
}

Rig ReadRig(const std::filesystem::path& file) {
  return ParseRig(ReadSettingsText(file, kRigFile), file);
}

}  // namespace ceilmap::calib
