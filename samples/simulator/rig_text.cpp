#include <fmt/format.h>

#include <Eigen/Geometry>
#include <numbers>
#include <string>

#include "samples/simulator/renderer.hpp"

namespace ceilmap::simulator {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

/// R in p_base = R p_cam + t.
Matrix3d UpRotation(const Camera& camera) {
  // x_cam = +y_base, y_cam = -x_base, z_cam = +z_base for a camera that is not turned.
  const double yaw = std::numbers::pi / 2 + camera.mount_yaw_deg * kDegree;
  const Eigen::Quaterniond R = AngleAxisd(camera.mount_roll_deg * kDegree, Vector3d::UnitX()) *
                               AngleAxisd(camera.mount_pitch_deg * kDegree, Vector3d::UnitY()) *
                               AngleAxisd(yaw, Vector3d::UnitZ());
  return R.toRotationMatrix();
}

Matrix3d ForwardRotation(const Camera& camera) {
  Matrix3d level;  // x_cam = -y_base, y_cam = -z_base, z_cam = +x_base
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Quaterniond R = AngleAxisd(camera.mount_yaw_deg * kDegree, Vector3d::UnitZ()) *
                               AngleAxisd(-camera.mount_pitch_deg * kDegree, Vector3d::UnitY()) *
                               AngleAxisd(camera.mount_roll_deg * kDegree, Vector3d::UnitX());
  return R.toRotationMatrix() * level;
}

/// A text in double quotes, as YAML reads it.
std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return quoted + '"';
}

/// Rounding noise such as 1e-17 as 0.
std::string Number(double value) {
  const std::string text = fmt::format("{:.9f}", value);
  return fmt::format("{:.12g}", std::stod(text) + 0.0);
}

std::string IntrinsicsText(const Camera& c) {
  const std::string f = fmt::format("{:.12g}", c.focal_px);
  const std::string cx = fmt::format("{:.12g}", (c.width_px - 1) / 2.0);
  const std::string cy = fmt::format("{:.12g}", (c.height_px - 1) / 2.0);
  std::string text = fmt::format(
      "    camera_matrix: {{rows: 3, cols: 3, data: [{}, 0, {}, 0, {}, {}, 0, 0, 1]}}\n",
      f,
      cx,
      f,
      cy);
  text += fmt::format(
      "    distortion_model: plumb_bob\n"
      "    distortion_coefficients: {{rows: 1, cols: 5, data: [{:.12g}]}}\n",
      fmt::join(c.distortion, ", "));
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

std::string PoseText(const char* name, const Camera& c, const Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  const auto row = [&R](int i, double t) {
    return fmt::format("{}, {}, {}, {:.12g}", Number(R(i, 0)), Number(R(i, 1)), Number(R(i, 2)), t);
  };
  std::string text = fmt::format("    base_link_to_camera:\n      frame: {}_optical_frame\n", name);
  text += fmt::format("      translation: [{:.12g}, {:.12g}, {:.12g}]\n",
                      c.mount_x_m,
                      c.mount_y_m,
                      c.mount_height_m);
  text += fmt::format("      rotation_xyzw: [{}, {}, {}, {}]\n",
                      Number(q.x()),
                      Number(q.y()),
                      Number(q.z()),
                      Number(q.w()));
  text += fmt::format("      matrix: [{}, {}, {}, 0, 0, 0, 1]\n",
                      row(0, c.mount_x_m),
                      row(1, c.mount_y_m),
                      row(2, c.mount_height_m));
  return text;
}

std::string CameraText(const char* name, const Camera& c, const Matrix3d& R) {
  std::string text = fmt::format("  {}:\n    type: pinhole\n", name);
  text += fmt::format("    image_width: {}\n    image_height: {}\n", c.width_px, c.height_px);
  text += fmt::format("    camera_name: {}\n", name);
  text += IntrinsicsText(c) + PoseText(name, c, R);
  text +=
      fmt::format("    exposure_time: {:.12g}   # s, the timestamp is the middle of the exposure\n",
                  c.exposure_time_s);
  return text;
}

}  // namespace

std::string RigYaml(const Scene& scene) {
  std::string text =
      "# lengths in metres, angles in radians; poses are \"camera optical frame in base_link\" "
      "(p_base = R p_cam + t)\n";
  text += fmt::format("robot: {}\n", Quoted(scene.robot));
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
  return text;
}

}  // namespace ceilmap::simulator
