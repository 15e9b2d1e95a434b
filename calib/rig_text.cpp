#include "calib/rig_text.hpp"

#include <yaml-cpp/yaml.h>

#include <numbers>
#include <string_view>
#include <vector>

#include "calib/base/error.hpp"
#include "calib/base/yaml_text.hpp"
#include "calib/base/yaml_value.hpp"
#include "calib/camera_info.hpp"
#include "calib/wheel_section.hpp"

namespace fs = std::filesystem;

namespace ceilmap::calib {
namespace {

YAML::Node List(const std::vector<double>& values) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const double value : values) list.push_back(NumberText(value));
  list.SetStyle(YAML::EmitterStyle::Flow);
  return list;
}

void SetPose(YAML::Node camera, const Eigen::Isometry3d& T_base_cam) {
  YAML::Node pose = camera["base_link_to_camera"];
  const Eigen::Quaterniond q(T_base_cam.linear());
  const Eigen::Matrix4d& m = T_base_cam.matrix();
  std::vector<double> rows;
  rows.reserve(static_cast<std::size_t>(m.size()));
  for (int i = 0; i < m.size(); ++i) rows.push_back(m(i / 4, i % 4));
  pose["translation"] = List({m(0, 3), m(1, 3), m(2, 3)});
  pose["rotation_xyzw"] = List({q.x(), q.y(), q.z(), q.w()});
  pose["matrix"] = List(rows);
}

bool Has(const YAML::Node& map, const char* key) {
  return map.IsMap() && map[key] && !map[key].IsNull();
}

// kMissing: only the values that the file lacks.
enum class Which { kAll, kMissing };

bool SetNumber(YAML::Node rig, const char* key, const std::optional<double>& value, Which which) {
  if (!value || (which == Which::kMissing && Has(rig, key))) return false;
  rig[key] = NumberText(*value);
  return true;
}

bool SetCamera(YAML::Node rig,
               const char* name,
               const std::optional<Eigen::Isometry3d>& T_base_cam,
               Which which) {
  if (!T_base_cam || !Has(rig, "cameras") || !Has(rig["cameras"], name)) return false;
  YAML::Node camera = rig["cameras"][name];
  if (!camera.IsMap()) return false;
  if (which == Which::kMissing && Has(camera, "base_link_to_camera")) return false;
  SetPose(camera, *T_base_cam);
  return true;
}

bool SetReadout(YAML::Node rig, const std::optional<double>& value, Which which) {
  if (!value || !Has(rig, "cameras") || !Has(rig["cameras"], "up")) return false;
  YAML::Node camera = rig["cameras"]["up"];
  return camera.IsMap() && SetNumber(camera, "readout_time_s", value, which);
}

void ShiftCamera(YAML::Node camera, const MirrorRing& ring) {
  YAML::Node mirror = camera["mirror"];
  const double scale = ring.outer_radius_px / mirror["rim_radius_px"].as<double>();
  YAML::Node data = camera["camera_matrix"]["data"];
  const auto at = [&data](int i) { return data[i].as<double>(); };
  YAML::Node changed =
      List({scale * at(0), 0, ring.centre_px.x(), 0, scale * at(4), ring.centre_px.y(), 0, 0, 1});
  camera["camera_matrix"]["data"] = changed;
  mirror["rim_radius_px"] = NumberText(ring.outer_radius_px);
  mirror["horizon_radius_px"] = NumberText(scale * mirror["horizon_radius_px"].as<double>());
  camera.remove("projection_matrix");  // it would describe the previous calibration
}

bool SetMirror(YAML::Node rig, const std::optional<MirrorValues>& values, Which which) {
  if (!values || which == Which::kMissing) return false;
  YAML::Node omni = rig["cameras"]["omni"];
  const MirrorRing& ring = values->ring;
  if (Has(omni, "type") && omni["type"].Scalar() == "hyperbolic_mirror" &&
      Has(omni, "camera_matrix")) {
    ShiftCamera(omni, ring);
    return true;
  }
  omni["type"] = "mirror";
  if (!Has(omni, "camera_info")) {
    omni["image_width"] = values->width_px;
    omni["image_height"] = values->height_px;
  }
  YAML::Node mirror;
  mirror["centre_px"] = List({ring.centre_px.x(), ring.centre_px.y()});
  mirror["inner_radius_px"] = NumberText(ring.inner_radius_px);
  mirror["outer_radius_px"] = NumberText(ring.outer_radius_px);
  mirror.SetStyle(YAML::EmitterStyle::Flow);
  omni["mirror"] = mirror;
  if (Has(omni, "base_link_to_camera")) return true;
  Eigen::Isometry3d T_base_cam = Eigen::Isometry3d::Identity();
  T_base_cam.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  SetPose(omni, T_base_cam);
  return true;
}

bool SetWheels(YAML::Node rig, const std::optional<wheels::WheelModel>& model, Which which) {
  if (!model || (which == Which::kMissing && Has(rig, "wheels"))) return false;
  YAML::Node section;
  for (const auto& [key, numbers] : WheelEntries(*model)) {
    if (numbers.size() == 1) {
      section[key] = NumberText(numbers.front());
    } else {
      section[key] = List({numbers[0], numbers[1]});
    }
  }
  rig["wheels"] = section;
  return true;
}

bool SetAll(const YAML::Node& rig, const RigValues& values, Which which) {
  bool changed = SetNumber(rig, "a", values.axle_behind_mast_m, which);
  changed |= SetNumber(rig, "h", values.ceiling_height_m, which);
  changed |= SetCamera(rig, "up", values.T_base_up, which);
  changed |= SetReadout(rig, values.up_readout_time_s, which);
  changed |= SetCamera(rig, "forward", values.T_base_forward, which);
  changed |= SetMirror(rig, values.omni, which);
  changed |= SetWheels(rig, values.wheels, which);
  return changed;
}

/// The file may contain anything in the place of a value: a word for a camera, a mirror without a
/// rim.
template <typename Change>
auto Changed(const fs::path& file, const Change& change) {
  try {
    return change();
  } catch (const YAML::Exception& error) {
    throw InputError(file.string() + ": values cannot be put into it: " + error.msg +
                     "; correct it there, or give " + std::string(kRigFile));
  }
}

YAML::Node Load(const std::string& text, const fs::path& file) {
  YamlValue::Parse(text, file, kRigFile);  // with its messages
  return YAML::Load(text);
}

void MovePaths(YAML::Node rig, const fs::path& from, const fs::path& to) {
  if (!Has(rig, "cameras") || !rig["cameras"].IsMap()) return;
  for (auto entry : rig["cameras"]) {
    YAML::Node camera = entry.second;
    if (!Has(camera, "camera_info") || !camera["camera_info"].IsScalar()) continue;
    const fs::path path(camera["camera_info"].Scalar());
    if (path.is_absolute()) continue;
    camera["camera_info"] =
        fs::absolute(from / path).lexically_proximate(fs::absolute(to)).lexically_normal().string();
  }
}

std::string Emit(const YAML::Node& rig) {
  YAML::Emitter emitter;
  emitter << rig;
  return std::string(emitter.c_str()) + "\n";
}

}  // namespace

std::string ChangeRig(const std::string& text,
                      const fs::path& file,
                      const RigValues& values,
                      const fs::path& target) {
  const YAML::Node rig = Load(text, file);
  return Changed(file, [&] {
    SetAll(rig, values, Which::kAll);
    const fs::path from = fs::absolute(file).parent_path().lexically_normal();
    const fs::path to = fs::absolute(target).parent_path().lexically_normal();
    if (from != to) MovePaths(rig, from, to);
    return Emit(rig);
  });
}

std::string CompleteRig(const std::string& text, const fs::path& file, const RigValues& values) {
  const YAML::Node rig = Load(text, file);
  return Changed(file, [&] { return SetAll(rig, values, Which::kMissing) ? Emit(rig) : text; });
}

std::string RigOfCameraInfo(const fs::path& camera_info) {
  ReadCameraInfo(camera_info);  // with its messages
  YAML::Node up = YAML::Load(ReadSettingsText(camera_info, "a ROS camera_info file"));
  YAML::Node rig;
  up["type"] = "pinhole";
  rig["cameras"]["up"] = up;
  return Emit(rig);
}

}  // namespace ceilmap::calib
