#include "ceilmap_ros/nodes/common_parameters.hpp"

#include <numbers>

#include "calib/base/error.hpp"
#include "calib/base/settings.hpp"
#include "localization/localizer_settings.hpp"
#include "localization/robot/sensor_settings.hpp"
#include "mapping/mapper_settings.hpp"

namespace ceilmap_ros {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

FileSettings ReadSettings(const std::string& file) {
  FileSettings values;
  if (file.empty()) return values;
  const ceilmap::Settings settings;
  ceilmap::mapping::Describe(values.mapping, settings.In("mapping"));
  ceilmap::robot::Describe(values.sensors, settings.In("sensors"));
  ceilmap::localization::Describe(values.localization, settings.In("localization"));
  settings.Load(file);
  return values;
}

}  // namespace

CommonParameters::CommonParameters(rclcpp::Node& node) {
  const std::string rig_file =
      Declare<std::string>(node, "rig", "", "Rig of the robot, rig.yaml (required)");
  if (rig_file.empty()) throw ceilmap::InputError("the parameter 'rig' is empty; set rig.yaml");
  rig = ceilmap::calib::ReadRig(rig_file);
  settings = ReadSettings(
      Declare<std::string>(node, "settings", "", "Settings file of ceilmap; empty: its defaults"));
  settings.sensors.measure_tilt = Declare<bool>(
      node, "measure_tilt", true, "Measure the robot's tilt; false: it is taken to be level");
  map_frame = Declare<std::string>(node, "map_frame", "map", "Frame of the map");
  odom_frame = Declare<std::string>(node, "odom_frame", "odom", "Frame of the odometry");
  base_frame = Declare<std::string>(
      node, "base_frame", "base_link", "Frame of the robot to which the rig gives its cameras");
  publish_tf = Declare<bool>(node, "publish_tf", true, "Publish map_frame -> odom_frame to TF");
  use_imu =
      Declare<bool>(node, "use_imu", false, "Take turns from the topic imu, whose z must point up");
  camera_from_info = Declare<bool>(
      node, "camera_from_info", false, "Lens of the upward camera from camera_info, not the rig");
  mosaic_max_px =
      Declare<int>(node, "mosaic_max_px", 2000, "Longest side of the topic ceiling_map, pixels");
  inbox.longest_wait_s = Declare<double>(
      node, "longest_wait", 0.2, "An image waits for odometry of its time this long, s");
  inbox.max_future_s = Declare<double>(
      node, "max_future", 0.1, "Images with stamps that are later than now by more are dropped, s");
  transform.transform_tolerance_s = Declare<double>(
      node, "transform_tolerance", 0.5, "The transform is stamped later than its image by this, s");
  transform.predicted_sigma_m = Declare<double>(
      node, "predicted_sigma", 0.1, "Poses by the wheels alone are published up to this sigma, m");
  transform.predicted_sigma_rad =
      kDegree * Declare<double>(node,
                                "predicted_sigma_yaw",
                                3,
                                "Poses by the wheels alone are published up to this sigma, deg");
}

}  // namespace ceilmap_ros
