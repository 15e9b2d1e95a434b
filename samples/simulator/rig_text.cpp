#include <fmt/format.h>

#include <Eigen/Geometry>
#include <numbers>
#include <string>

#include "samples/simulator/renderer.hpp"

namespace ceilmap::simulator {
namespace {

Eigen::Matrix3d RotationBaseCam(const Camera& camera) {
  constexpr double kDegree = std::numbers::pi / 180;
  // x_cam = +y_base, y_cam = -x_base, z_cam = +z_base for a camera that is not turned.
  const double yaw = std::numbers::pi / 2 + camera.mount_yaw_deg * kDegree;
  const Eigen::Quaterniond R =
      Eigen::AngleAxisd(camera.mount_roll_deg * kDegree, Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(camera.mount_pitch_deg * kDegree, Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  return R.toRotationMatrix();
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

}  // namespace

std::string RigYaml(const Scene& scene) {
  const Camera& c = scene.camera;
  const Eigen::Matrix3d R = RotationBaseCam(c);
  const Eigen::Quaterniond q(R);
  const std::string f = fmt::format("{:.12g}", c.focal_px);
  const std::string cx = fmt::format("{:.12g}", (c.width_px - 1) / 2.0);
  const std::string cy = fmt::format("{:.12g}", (c.height_px - 1) / 2.0);
  const auto row = [&R](int i, double t) {
    return fmt::format("{}, {}, {}, {:.12g}", Number(R(i, 0)), Number(R(i, 1)), Number(R(i, 2)), t);
  };
  std::string text =
      "# lengths in metres, angles in radians; poses are \"camera optical frame in base_link\" "
      "(p_base = R p_cam + t)\n";
  text += fmt::format("robot: {}\n", Quoted(scene.robot));
  text += fmt::format("a: {:.12g}   # the pivot axle is at base_link x = -a\n",
                      scene.axle_behind_mast_m);
  text += "d: null\n";
  text += fmt::format("h: {:.12g}   # ceiling height above the floor\n", scene.room.height_m);
  text += "frames: {map: room, base: base_link}\ncameras:\n  up:\n    type: pinhole\n";
  text += fmt::format("    image_width: {}\n    image_height: {}\n", c.width_px, c.height_px);
  text += "    camera_name: up\n";
  text += fmt::format(
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
  text += "    base_link_to_camera:\n      frame: up_optical_frame\n";
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
  text +=
      fmt::format("    exposure_time: {:.12g}   # s, the timestamp is the middle of the exposure\n",
                  c.exposure_time_s);
  return text;
}

}  // namespace ceilmap::simulator
