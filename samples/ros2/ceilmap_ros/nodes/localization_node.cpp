#include "ceilmap_ros/nodes/localization_node.hpp"

#include <fmt/format.h>

#include <memory>
#include <rclcpp_components/register_node_macro.hpp>

#include "calib/base/error.hpp"
#include "ceilmap_ros/logic/start_pose.hpp"
#include "ceilmap_ros/nodes/messages.hpp"
#include "ceilmap_ros/nodes/respond.hpp"

namespace ceilmap_ros {
namespace {

LocalizationOptions ToLocalizationOptions(const CommonParameters& parameters) {
  LocalizationOptions params;
  params.inbox = parameters.inbox;
  params.transform = parameters.transform;
  params.camera_from_info = parameters.camera_from_info;
  params.mosaic_max_px = parameters.mosaic_max_px;
  params.localizer.sensors = parameters.settings.sensors;
  params.localizer.localization = parameters.settings.localization;
  return params;
}

}  // namespace

LocalizationNode::LocalizationNode(const rclcpp::NodeOptions& options)
    : Node("ceilmap_localization", options),
      parameters_(*this),
      logic_(parameters_.rig, ToLocalizationOptions(parameters_)),
      fixes_(*this, parameters_),
      ceiling_map_(create_publisher<nav_msgs::msg::OccupancyGrid>(
          "ceiling_map", rclcpp::QoS(1).reliable().transient_local())),
      diagnostics_(
          *this, parameters_.rig.robot, [this](Stamp now) { return logic_.Diagnose(now); }),
      sensors_(*this, parameters_, logic_.Sensors()),
      worker_(logic_.Sensors(), [this] { Step(); }) {
  initial_pose_ = create_subscription<InitialPose>(
      "initialpose", rclcpp::QoS(1), [this](InitialPose::ConstSharedPtr pose) {
        TakeInitialPose(*pose);
      });
  relocalize_ = create_service<Trigger>(
      "~/relocalize",
      [this](std::shared_ptr<Trigger::Request> /*request*/,
             std::shared_ptr<Trigger::Response> response) {
        logic_.Sensors().RequestStart({});
        response->success = true;
        response->message = "the robot is searched on the whole map, from the next image on";
      });
  // A large map takes seconds: the answer is sent when it is read.
  load_map_ = create_service<srv::LoadMap>(
      "~/load_map",
      [this](std::shared_ptr<rclcpp::Service<srv::LoadMap>> service,
             std::shared_ptr<rmw_request_id_t> id,
             std::shared_ptr<srv::LoadMap::Request> request) {
        tasks_.Add([this, service, id, request] {
          Respond<srv::LoadMap>(*service, *id, Load(request->path), get_logger());
        });
      });
  const std::string map =
      Declare<std::string>(*this, "map", "", "Map to start with, NAME.gpkg; empty: load_map");
  if (!map.empty()) tasks_.Add([this, map] { (void)Load(map); });
}

void LocalizationNode::Step() {
  try {
    if (const auto fix = logic_.Step(now().nanoseconds())) fixes_.Publish(*fix);
  } catch (const std::exception& error) {  // ROS ends
    RCLCPP_ERROR(get_logger(), "%s", error.what());
  }
}

srv::LoadMap::Response LocalizationNode::Load(const std::string& path) {
  srv::LoadMap::Response response;
  try {
    nav_msgs::msg::OccupancyGrid grid = ToOccupancyGrid(logic_.LoadMap(path));
    grid.header.stamp = ToTime(now().nanoseconds());
    grid.header.frame_id = parameters_.map_frame;
    grid.info.map_load_time = grid.header.stamp;
    ceiling_map_->publish(grid);
    response.success = true;
    response.message = fmt::format("{} is loaded", path);
    RCLCPP_INFO(get_logger(), "%s", response.message.c_str());
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
    RCLCPP_ERROR(get_logger(), "%s", error.what());
  }
  return response;
}

void LocalizationNode::TakeInitialPose(const InitialPose& message) {
  if (message.header.frame_id != parameters_.map_frame) {
    RCLCPP_WARN(get_logger(),
                "initialpose is in the frame '%s', must be '%s'; set RViz's fixed frame",
                message.header.frame_id.c_str(),
                parameters_.map_frame.c_str());
    return;
  }
  const auto pose = ToPose2(message.pose.pose);
  if (!pose) {
    RCLCPP_WARN(get_logger(), "initialpose has a quaternion that is no rotation");
    return;
  }
  try {
    StartRequest start;
    start.pose = CheckedStart(*pose, ToCovariance(message.pose));
    start.stamp = ToStamp(message.header.stamp);
    logic_.Sensors().RequestStart(start);
  } catch (const ceilmap::InputError& error) {
    RCLCPP_WARN(get_logger(), "%s", error.what());
  }
}

}  // namespace ceilmap_ros

RCLCPP_COMPONENTS_REGISTER_NODE(ceilmap_ros::LocalizationNode)
