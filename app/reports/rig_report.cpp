#include "app/reports/rig_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/one_line.hpp"
#include "calib/rig_checks.hpp"
#include "calib/rig_facts.hpp"

namespace ceilmap::reports {
namespace {

using nlohmann::ordered_json;

constexpr double kExactDeg = 0.5;  // a smaller angle is not printed

std::string FieldOfViewText(const std::optional<calib::FieldOfView>& view) {
  if (!view) return "not known: the lens model is not valid in the complete image";
  return fmt::format("{:.1f} x {:.1f} deg, diagonal {:.1f} deg",
                     view->horizontal_rad * kDegPerRad,
                     view->vertical_rad * kDegPerRad,
                     view->diagonal_rad * kDegPerRad);
}

std::string PlaceText(const calib::MountedCamera& camera) {
  const Eigen::Vector3d& t = camera.T_base_cam.translation();
  return fmt::format("{} x {} px at x, y, z = {:.3f}, {:.3f}, {:.3f} m",
                     camera.camera.width_px,
                     camera.camera.height_px,
                     t.x(),
                     t.y(),
                     t.z());
}

std::string AxleText(double behind_m) {
  if (behind_m == 0) return "below the origin of base (a = 0)";
  return fmt::format("{:.3f} m {} the origin of base (a {} 0)",
                     std::abs(behind_m),
                     behind_m > 0 ? "behind" : "ahead of",
                     behind_m > 0 ? ">" : "<");
}

void AddUp(const calib::MountedCamera& camera, const calib::UpFacts& up, terminal::Table& table) {
  table.AddRow({"upward camera", PlaceText(camera)});
  table.AddRow({"  field of view", FieldOfViewText(up.field_of_view)});
  if (up.view_px != camera.camera.Size() || camera.view) {
    table.AddRow({"  view",
                  fmt::format("{} x {} px, {}, {}",
                              up.view_px.width,
                              up.view_px.height,
                              FieldOfViewText(up.view),
                              camera.view ? "as the rig states" : "chosen from the lens")});
  }
  table.AddRow({"  sees",
                fmt::format("{:.2f} x {:.2f} m of the ceiling, {:.2f} m above it, at {:.3g} mm per "
                            "pixel",
                            up.ceiling_m.x(),
                            up.ceiling_m.y(),
                            up.distance_m,
                            1e3 * up.m_per_px)});
  table.AddRow({"  top of image", DirectionText(up.top_yaw_rad)});
  table.AddRow({"  right of image", DirectionText(up.right_yaw_rad)});
  table.AddRow({"  tilt", fmt::format("{:.1f} deg from the vertical", up.tilt_rad * kDegPerRad)});
  if (camera.readout_time_s != 0) {
    table.AddRow({"  rolling shutter",
                  fmt::format("{:.3g} ms, {} row first",
                              1e3 * std::abs(camera.readout_time_s),
                              camera.readout_time_s > 0 ? "top" : "bottom")});
  }
}

std::string AxisText(const calib::ForwardFacts& forward) {
  const double up_deg = forward.elevation_rad * kDegPerRad;
  return fmt::format(
      "{}, {}",
      DirectionText(forward.yaw_rad),
      std::abs(up_deg) < kExactDeg
          ? std::string("level")
          : fmt::format("{:.1f} deg {}", std::abs(up_deg), up_deg > 0 ? "up" : "down"));
}

void AddForward(const calib::MountedCamera& camera,
                const calib::ForwardFacts& forward,
                terminal::Table& table) {
  table.AddRow({"forward camera", PlaceText(camera)});
  table.AddRow({"  field of view", FieldOfViewText(forward.field_of_view)});
  table.AddRow({"  looks at", AxisText(forward)});
  table.AddRow({"  top of image", forward.upside_down ? "down" : "up"});
  table.AddRow(
      {"  horizon",
       forward.horizon_row_px
           ? fmt::format("row {:.1f} of {}", *forward.horizon_row_px, camera.camera.height_px)
           : "outside the image"});
}

void AddOmni(const calib::MountedCamera& camera,
             const calib::OmniFacts& omni,
             terminal::Table& table) {
  table.AddRow({"mirror camera", PlaceText(camera)});
  table.AddRow(
      {"  mirror",
       fmt::format("{} px about u, v = {:.1f}, {:.1f}",
                   omni.inner_radius_px ? fmt::format("ring of {:.1f} to {:.1f}",
                                                      *omni.inner_radius_px,
                                                      omni.outer_radius_px)
                                        : fmt::format("rim of {:.1f}", omni.outer_radius_px),
                   omni.centre_px.x(),
                   omni.centre_px.y())});
  if (omni.rim_elevation_rad) {
    table.AddRow({"  sees",
                  fmt::format("all around, up to {:.1f} deg above the horizon",
                              *omni.rim_elevation_rad * kDegPerRad)});
  }
  table.AddRow({"  top of image", DirectionText(omni.top_yaw_rad)});
  table.AddRow({"  tilt", fmt::format("{:.1f} deg from the vertical", omni.tilt_rad * kDegPerRad)});
}

ordered_json ToJson(const std::optional<calib::FieldOfView>& view) {
  if (!view) return nullptr;
  return {{"horizontal", view->horizontal_rad * kDegPerRad},
          {"vertical", view->vertical_rad * kDegPerRad},
          {"diagonal", view->diagonal_rad * kDegPerRad}};
}

ordered_json CameraJson(const calib::MountedCamera& camera) {
  const Eigen::Vector3d& t = camera.T_base_cam.translation();
  return {{"width_px", camera.camera.width_px},
          {"height_px", camera.camera.height_px},
          {"position_m", {t.x(), t.y(), t.z()}}};
}

ordered_json ToJson(const calib::MountedCamera& camera, const calib::UpFacts& up) {
  ordered_json json = CameraJson(camera);
  json["field_of_view_deg"] = ToJson(up.field_of_view);
  json["view_px"] = {up.view_px.width, up.view_px.height};
  json["view_field_of_view_deg"] = ToJson(up.view);
  json["distance_m"] = up.distance_m;
  json["m_per_px"] = up.m_per_px;
  json["ceiling_m"] = {up.ceiling_m.x(), up.ceiling_m.y()};
  json["image_top_yaw_deg"] = up.top_yaw_rad * kDegPerRad;
  json["image_right_yaw_deg"] = up.right_yaw_rad * kDegPerRad;
  json["tilt_deg"] = up.tilt_rad * kDegPerRad;
  json["readout_time_s"] = camera.readout_time_s;
  return json;
}

ordered_json ToJson(const calib::MountedCamera& camera, const calib::ForwardFacts& forward) {
  ordered_json json = CameraJson(camera);
  json["field_of_view_deg"] = ToJson(forward.field_of_view);
  json["yaw_deg"] = forward.yaw_rad * kDegPerRad;
  json["elevation_deg"] = forward.elevation_rad * kDegPerRad;
  json["upside_down"] = forward.upside_down;
  json["horizon_row_px"] =
      forward.horizon_row_px ? ordered_json(*forward.horizon_row_px) : ordered_json();
  return json;
}

ordered_json ToJson(const calib::MountedCamera& camera, const calib::OmniFacts& omni) {
  ordered_json json = CameraJson(camera);
  json["centre_px"] = {omni.centre_px.x(), omni.centre_px.y()};
  json["outer_radius_px"] = omni.outer_radius_px;
  if (omni.inner_radius_px) json["inner_radius_px"] = *omni.inner_radius_px;
  if (omni.rim_elevation_rad) json["rim_elevation_deg"] = *omni.rim_elevation_rad * kDegPerRad;
  json["image_top_yaw_deg"] = omni.top_yaw_rad * kDegPerRad;
  json["tilt_deg"] = omni.tilt_rad * kDegPerRad;
  return json;
}

}  // namespace

std::string DirectionText(double yaw_rad) {
  const double deg = yaw_rad * kDegPerRad;
  if (std::abs(deg) < kExactDeg) return "the robot's front";
  if (std::abs(deg) > 180 - kExactDeg) return "the robot's back";
  const char* const side = deg > 0 ? "left" : "right";
  if (std::abs(std::abs(deg) - 90) < kExactDeg) return fmt::format("the robot's {}", side);
  return fmt::format("{:.1f} deg to the {} of the robot's front", std::abs(deg), side);
}

terminal::Table DescribeRig(const calib::Rig& rig) {
  const calib::RigFacts facts = calib::DescribeRig(rig);
  terminal::Table table;
  table.AddRow({"robot", rig.robot.empty() ? "not named" : InOneLine(rig.robot)});
  table.AddRow({"ceiling", fmt::format("{:.3f} m above the floor", rig.ceiling_height_m)});
  table.AddRow({"axle", AxleText(rig.axle_behind_mast_m)});
  if (facts.up) AddUp(*rig.up, *facts.up, table);
  if (facts.forward) AddForward(*rig.forward, *facts.forward, table);
  if (facts.omni) AddOmni(*rig.omni, *facts.omni, table);
  const char* name = "assumed";
  for (const std::string& value : rig.assumed) {
    table.AddRow({name, value});
    name = "";
  }
  return table;
}

ordered_json RigJson(const calib::Rig& rig) {
  const calib::RigFacts facts = calib::DescribeRig(rig);
  ordered_json cameras = ordered_json::object();
  if (facts.up) cameras["up"] = ToJson(*rig.up, *facts.up);
  if (facts.forward) cameras["forward"] = ToJson(*rig.forward, *facts.forward);
  if (facts.omni) cameras["omni"] = ToJson(*rig.omni, *facts.omni);
  return {{"robot", rig.robot},
          {"ceiling_height_m", rig.ceiling_height_m},
          {"axle_behind_mast_m", rig.axle_behind_mast_m},
          {"cameras", cameras},
          {"assumed", rig.assumed},
          {"warnings", calib::RigWarnings(rig)}};
}

}  // namespace ceilmap::reports
