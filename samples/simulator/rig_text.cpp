#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <numbers>
#include <string>

#include "calib/base/degrees.hpp"
#include "calib/base/yaml_text.hpp"
#include "samples/simulator/mirror_rays.hpp"
#include "samples/simulator/renderer.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// R in p_base = R p_cam + t.
Matrix3d UpRotation(const Camera& camera) {
  // x_cam = +y_base, y_cam = -x_base, z_cam = +z_base for a camera without rotation.
  const double yaw = std::numbers::pi / 2 + camera.mount_yaw_deg * kRadPerDeg;
  const Eigen::Quaterniond R = AngleAxisd(camera.mount_roll_deg * kRadPerDeg, Vector3d::UnitX()) *
                               AngleAxisd(camera.mount_pitch_deg * kRadPerDeg, Vector3d::UnitY()) *
                               AngleAxisd(yaw, Vector3d::UnitZ());
  return R.toRotationMatrix();
}

Matrix3d ForwardRotation(const Camera& camera) {
  Matrix3d level;  // x_cam = -y_base, y_cam = -z_base, z_cam = +x_base
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Quaterniond R = AngleAxisd(camera.mount_yaw_deg * kRadPerDeg, Vector3d::UnitZ()) *
                               AngleAxisd(-camera.mount_pitch_deg * kRadPerDeg, Vector3d::UnitY()) *
                               AngleAxisd(camera.mount_roll_deg * kRadPerDeg, Vector3d::UnitX());
  return R.toRotationMatrix() * level;
}

/// Common part of all kinds of cameras; without distortion if none is given.
struct Intrinsics {
  int width_px = 0;
  int height_px = 0;
  double focal_px = 0;
  double offset_x_px = 0;  // of the principal point from the image's centre
  double offset_y_px = 0;
  calib::LensModel model = calib::LensModel::kPlumbBob;
  std::array<double, 8> distortion{};
};

std::string IntrinsicsText(const char* name, const Intrinsics& c) {
  const std::string f = fmt::format("{:.12g}", c.focal_px);
  const std::string cx = fmt::format("{:.12g}", (c.width_px - 1) / 2.0 + c.offset_x_px);
  const std::string cy = fmt::format("{:.12g}", (c.height_px - 1) / 2.0 + c.offset_y_px);
  std::string text =
      fmt::format("    image_width: {}\n    image_height: {}\n", c.width_px, c.height_px);
  text += fmt::format("    camera_name: {}\n", name);
  text += fmt::format(
      "    camera_matrix: {{rows: 3, cols: 3, data: [{}, 0, {}, 0, {}, {}, 0, 0, 1]}}\n",
      f,
      cx,
      f,
      cy);
  const std::size_t count = calib::CoefficientNames(c.model).size();
  text += fmt::format(
      "    distortion_model: {}\n"
      "    distortion_coefficients: {{rows: 1, cols: {}, data: [{:.12g}]}}\n",
      calib::RosName(c.model),
      count,
      fmt::join(c.distortion.begin(), c.distortion.begin() + count, ", "));
  text += "    rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n";
  text += fmt::format(
      "    projection_matrix: {{rows: 3, cols: 4, data: [{}, 0, {}, 0, 0, {}, {}, 0, 0, 0, 1, "
      "0]}}\n",
      f,
      cx,
      f,
      cy);
  return text;
}

/// @param R, t  p_base = R p_cam + t.
std::string PoseText(const char* name, const Matrix3d& R, const Vector3d& t) {
  const Eigen::Quaterniond q(R);
  const auto row = [&R](int i, double t_i) {
    return fmt::format(
        "{}, {}, {}, {:.12g}", NumberText(R(i, 0)), NumberText(R(i, 1)), NumberText(R(i, 2)), t_i);
  };
  std::string text = fmt::format("    base_link_to_camera:\n      frame: {}_optical_frame\n", name);
  text += fmt::format("      translation: [{:.12g}, {:.12g}, {:.12g}]\n", t.x(), t.y(), t.z());
  text += fmt::format("      rotation_xyzw: [{}, {}, {}, {}]\n",
                      NumberText(q.x()),
                      NumberText(q.y()),
                      NumberText(q.z()),
                      NumberText(q.w()));
  text += fmt::format(
      "      matrix: [{}, {}, {}, 0, 0, 0, 1]\n", row(0, t.x()), row(1, t.y()), row(2, t.z()));
  return text;
}

std::string ExposureText(double exposure_time_s) {
  return fmt::format(
      "    exposure_time: {:.12g}   # s, the timestamp is the middle of the exposure\n",
      exposure_time_s);
}

std::string ReadoutText(double readout_time_s) {
  if (readout_time_s == 0) return "";
  return fmt::format("    readout_time_s: {:.12g}   # from the first to the last row\n",
                     readout_time_s);
}

std::string CameraText(const char* name, const Camera& c, const Matrix3d& R) {
  return fmt::format("  {}:\n    type: pinhole\n", name) +
         IntrinsicsText(
             name, {c.width_px, c.height_px, c.focal_px, 0, 0, c.distortion_model, c.distortion}) +
         PoseText(name, R, {c.mount_x_m, c.mount_y_m, c.mount_height_m}) +
         ExposureText(c.exposure_time_s) + ReadoutText(c.readout_time_s);
}

std::string OmniText(const OmniCamera& c) {
  const MirrorRays rays(c);
  const Vector3d t(c.mount_x_m, c.mount_y_m, c.mount_height_m);
  Intrinsics intrinsics{c.width_px, c.height_px, c.focal_px};
  if (c.centre_in_rig) {
    intrinsics.offset_x_px = c.centre_offset_px[0];
    intrinsics.offset_y_px = c.centre_offset_px[1];
  }
  std::string text = "  omni:\n    type: hyperbolic_mirror\n" + IntrinsicsText("omni", intrinsics) +
                     PoseText("omni", rays.R_base_cam(), t) + ExposureText(0);
  text +=
      "    mirror:\n"
      "      # z^2/A^2 - r^2/B^2 = 1, upper sheet; pinhole at (0, 0, -C), viewpoint at (0, 0, C)\n";
  text += fmt::format("      A: {:.12g}\n      B: {:.12g}\n      C: {:.12g}\n",
                      c.mirror_a_m,
                      c.mirror_b_m,
                      c.FocusM());
  text += fmt::format("      rim_radius: {:.12g}\n", c.rim_radius_m);
  const Vector3d viewpoint = rays.ViewpointInBase();
  text += fmt::format("      base_link_to_viewpoint: [{:.12g}, {:.12g}, {:.12g}]\n",
                      viewpoint.x(),
                      viewpoint.y(),
                      viewpoint.z());
  text += fmt::format("      rim_radius_px: {:.9g}\n      horizon_radius_px: {:.9g}\n",
                      rays.RimRadiusPx(),
                      rays.HorizonRadiusPx());
  return text;
}

}  // namespace

std::string RigYaml(const Scene& scene) {
  std::string text =
      "# lengths in metres, angles in radians; poses are \"camera optical frame in base_link\" "
      "(p_base = R p_cam + t)\n";
  text += fmt::format("robot: {}\n", QuotedText(scene.robot));
  text += fmt::format("a: {:.12g}   # the pivot axle is at base_link x = -a\n",
                      scene.axle_behind_mast_m);
  text += scene.forward
              ? fmt::format("d: {:.12g}   # height of the forward camera above the floor\n",
                            scene.forward->mount_height_m)
              : "d: null\n";
  text += fmt::format("h: {:.12g}   # ceiling height above the floor\n", scene.room.height_m);
  text += "frames: {map: room, base: base_link}\ncameras:\n";
  text += CameraText("up", scene.camera, UpRotation(scene.camera));
  if (scene.forward) text += CameraText("forward", *scene.forward, ForwardRotation(*scene.forward));
  if (scene.omni) text += OmniText(*scene.omni);
  return text;
}

}  // namespace ceilmap::simulator
