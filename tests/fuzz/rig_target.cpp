#include <algorithm>
#include <cmath>
#include <string>

#include "calib/rig.hpp"
#include "calib/rig_checks.hpp"
#include "calib/rig_facts.hpp"
#include "calib/rig_text.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {
namespace {

// Relative paths in a rig lead to a folder that is not there.
constexpr const char* kFile = "/nowhere/rig.yaml";

void CheckCamera(const calib::MountedCamera& mounted) {
  const calib::Lens& camera = mounted.camera;
  Require(camera.width_px > 0 && camera.height_px > 0, "a camera without an image");
  Require(camera.fx >= 0 && camera.fy >= 0 && std::isfinite(camera.fx + camera.fy) &&
              std::isfinite(camera.cx) && std::isfinite(camera.cy),
          "intrinsics that cannot be");
  Require(camera.fx > 0 || mounted.mirror_ring, "no focal length");
  const Eigen::Matrix3d R = mounted.T_base_cam.linear();
  Require((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-9, "no rotation");
  Require(mounted.T_base_cam.matrix().allFinite(), "a pose that is not finite");
}

void CheckRig(const calib::Rig& rig) {
  Require(std::isfinite(rig.axle_behind_mast_m) && rig.ceiling_height_m > 0, "a or h");
  Require(rig.up || rig.forward || rig.omni, "a rig without cameras");
  for (const auto* camera : {&rig.up, &rig.forward, &rig.omni}) {
    if (*camera) CheckCamera(**camera);
  }
  for (const std::string& warning : calib::RigWarnings(rig)) {
    Require(warning.find('\n') == std::string::npos, "a warning of several lines");
  }
  (void)calib::DescribeRig(rig);
}

bool Same(const calib::Rig& a, const calib::Rig& b) {
  const auto same_camera = [](const std::optional<calib::MountedCamera>& x,
                              const std::optional<calib::MountedCamera>& y) {
    if (!x || !y) return x.has_value() == y.has_value();
    return x->camera.fx == y->camera.fx && x->camera.cy == y->camera.cy &&
           x->camera.distortion == y->camera.distortion &&
           x->T_base_cam.matrix() == y->T_base_cam.matrix();
  };
  // A name that is not UTF-8 is written as what is.
  const auto ascii = [](unsigned char c) { return c < 128; };
  const bool same_name = a.robot == b.robot || !std::all_of(a.robot.begin(), a.robot.end(), ascii);
  return same_name && a.axle_behind_mast_m == b.axle_behind_mast_m &&
         a.ceiling_height_m == b.ceiling_height_m && same_camera(a.up, b.up) &&
         same_camera(a.forward, b.forward) && same_camera(a.omni, b.omni);
}

}  // namespace

void ReadAsRig(std::string_view bytes) {
  const std::string text(bytes);
  const auto rig = Accepted([&] { return calib::ParseRig(text, kFile); });
  if (!rig) return;
  CheckRig(*rig);
  // Nothing is set: the same rig, written anew.
  const std::string written = calib::ChangeRig(text, kFile, {}, kFile);
  Require(Same(calib::ParseRig(written, kFile), *rig), "a rig reads back as another one");
}

// Values are put into rigs that are not complete yet.
void ReadAsRigToChange(std::string_view bytes) {
  const std::string text(bytes);
  calib::RigValues values;
  values.axle_behind_mast_m = 0.14;
  values.ceiling_height_m = 2.6;
  values.T_base_up = values.T_base_forward = Eigen::Isometry3d::Identity();
  values.omni = {{{100, 100}, 30, 90}, 201, 201};
  (void)Accepted([&] { return calib::ChangeRig(text, kFile, values, "/elsewhere/rig.yaml"); });
  (void)Accepted([&] { return calib::CompleteRig(text, kFile, values); });
}

}  // namespace ceilmap::fuzz
