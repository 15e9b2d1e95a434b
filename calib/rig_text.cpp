#include "calib/rig_text.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "calib/camera_info.hpp"
#include "calib/yaml_value.hpp"

namespace fs = std::filesystem;

namespace ceilmap::calib {
namespace {

constexpr std::string_view kWhat = "a rig file (format: calib/README.md)";

// Rounding noise such as 1e-17 as 0.
std::string Number(double value) {
  const std::string text = fmt::format("{:.9f}", value);
  return fmt::format("{:.12g}", std::stod(text) + 0.0);
}

YAML::Node List(const std::vector<double>& values) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (const double value : values) list.push_back(Number(value));
  list.SetStyle(YAML::EmitterStyle::Flow);
  return list;
}

void SetPose(YAML::Node camera, const Eigen::Isometry3d& T_base_cam) {
  YAML::Node pose = camera["base_link_to_camera"];
  const Eigen::Quaterniond q(T_base_cam.linear());
  const Eigen::Matrix4d m = T_base_cam.matrix();
  std::vector<double> rows;
  for (int i = 0; i < m.size(); ++i) rows.push_back(m(i / 4, i % 4));
  pose["translation"] = List({m(0, 3), m(1, 3), m(2, 3)});
  pose["rotation_xyzw"] = List({q.x(), q.y(), q.z(), q.w()});
  pose["matrix"] = List(rows);
}

bool Has(const YAML::Node& map, const char* key) {
  return map.IsMap() && map[key] && !map[key].IsNull();
}

// Only those that ask for it.
enum class Which { kAll, kMissing };

bool SetNumber(YAML::Node rig, const char* key, const std::optional<double>& value, Which which) {
  if (!value || (which == Which::kMissing && Has(rig, key))) return false;
  rig[key] = Number(*value);
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

bool SetAll(YAML::Node rig, const RigValues& values, Which which) {
  bool changed = SetNumber(rig, "a", values.axle_behind_mast_m, which);
  changed |= SetNumber(rig, "h", values.ceiling_height_m, which);
  changed |= SetCamera(rig, "up", values.T_base_up, which);
  changed |= SetCamera(rig, "forward", values.T_base_forward, which);
  return changed;
}

YAML::Node Load(const std::string& text, const fs::path& file) {
  YamlValue::Parse(text, file, kWhat);  // with its messages
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
  SetAll(rig, values, Which::kAll);
  const fs::path from = fs::absolute(file).parent_path().lexically_normal();
  const fs::path to = fs::absolute(target).parent_path().lexically_normal();
  if (from != to) MovePaths(rig, from, to);
  return Emit(rig);
}

std::string CompleteRig(const std::string& text, const fs::path& file, const RigValues& values) {
  const YAML::Node rig = Load(text, file);
  return SetAll(rig, values, Which::kMissing) ? Emit(rig) : text;
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
