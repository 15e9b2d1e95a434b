#pragma once

#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rclcpp/rclcpp.hpp>
#include <string>

#include "calib/rig.hpp"
#include "ceilmap_ros/logic/inbox.hpp"
#include "ceilmap_ros/logic/map_to_odom.hpp"
#include "localization/localizer.hpp"
#include "localization/robot/sensors.hpp"
#include "mapping/mapper.hpp"

namespace ceilmap_ros {

/// Declares a parameter that is read once, at the start of the node.
template <typename Value>
Value Declare(rclcpp::Node& node,
              const std::string& name,
              const Value& default_value,
              const std::string& description) {
  rcl_interfaces::msg::ParameterDescriptor descriptor;
  descriptor.description = description;
  descriptor.read_only = true;
  return node.declare_parameter<Value>(name, default_value, descriptor);
}

/// The values of a settings file (ceilmap settings).
struct FileSettings {
  ceilmap::mapping::MapperParams mapping;
  ceilmap::robot::SensorsParams sensors;
  ceilmap::localization::LocalizerParams localization;
};

/// What both nodes have.
struct CommonParameters {
  /// Declares and reads them. @throws InputError when rig or settings cannot be used.
  explicit CommonParameters(rclcpp::Node& node);

  ceilmap::calib::Rig rig;
  FileSettings settings;
  std::string map_frame;
  std::string odom_frame;
  std::string base_frame;
  bool publish_tf = true;
  bool use_imu = false;
  bool camera_from_info = false;
  int mosaic_max_px = 0;
  InboxOptions inbox;
  MapToOdomOptions transform;
};

}  // namespace ceilmap_ros
