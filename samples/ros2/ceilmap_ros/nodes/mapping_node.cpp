#include "ceilmap_ros/nodes/mapping_node.hpp"

#include <numbers>
#include <rclcpp_components/register_node_macro.hpp>
#include <string>
#include <vector>

#include "calib/base/error.hpp"
#include "ceilmap_ros/nodes/messages.hpp"
#include "ceilmap_ros/nodes/respond.hpp"

namespace ceilmap_ros {
namespace {

Pose2 ToOrigin(const std::vector<double>& values) {
  if (values.size() != 3) {
    throw ceilmap::InputError("the parameter 'origin' must have three values: x, y (m), yaw (deg)");
  }
  return {values[0], values[1], values[2] * std::numbers::pi / 180};
}

std::unique_ptr<MappingLogic> MakeLogic(rclcpp::Node& node, const CommonParameters& parameters) {
  MappingOptions params;
  params.inbox = parameters.inbox;
  params.transform = parameters.transform;
  params.camera_from_info = parameters.camera_from_info;
  params.mosaic_max_px = parameters.mosaic_max_px;
  params.map = Declare<std::string>(node, "map", "", "Map to be written, NAME.gpkg (required)");
  if (params.map.empty()) throw ceilmap::InputError("the parameter 'map' is empty; set NAME.gpkg");
  params.mapper.sensors = parameters.settings.sensors;
  params.mapper.mapping = parameters.settings.mapping;
  if (Declare<bool>(node, "append", false, "Extend the map, wherever on it the robot starts")) {
    params.mapper.append = ceilmap::mapping::HeldPoses::kFirstKeyframe;
  }
  params.mapper.mapping.origin = ToOrigin(Declare<std::vector<double>>(
      node,
      "origin",
      {0, 0, 0},
      "Pose of the robot on the map at its first image: x, y, yaw; m, deg"));
  params.mapper.provenance = "ceilmap_ros";
  params.mapper.source = "the robot's images";
  return std::make_unique<MappingLogic>(parameters.rig, params);
}

}  // namespace

MappingNode::MappingNode(const rclcpp::NodeOptions& options)
    : Node("ceilmap_mapping", options),
      parameters_(*this),
      mosaic_period_(FromSeconds(Declare<double>(
          *this, "mosaic_period", 2, "The topic ceiling_map is published this often, s"))),
      logic_(MakeLogic(*this, parameters_)),
      fixes_(*this, parameters_),
      ceiling_map_(create_publisher<nav_msgs::msg::OccupancyGrid>(
          "ceiling_map", rclcpp::QoS(1).reliable().transient_local())),
      diagnostics_(
          *this, parameters_.rig.robot, [this](Stamp now) { return logic_->Diagnose(now); }),
      sensors_(*this, parameters_, logic_->Sensors()),
      worker_(logic_->Sensors(), [this] { Step(); }) {
  // Saving takes from seconds to minutes: the answer is sent when it is done.
  save_map_ = create_service<srv::SaveMap>(
      "~/save_map",
      [this](std::shared_ptr<rclcpp::Service<srv::SaveMap>> service,
             std::shared_ptr<rmw_request_id_t> id,
             std::shared_ptr<srv::SaveMap::Request> request) {
        logic_->RequestSave(request->path, [this, service, id](const SaveResult& result) {
          srv::SaveMap::Response response;
          response.success = result.success;
          response.message = result.message;
          Respond<srv::SaveMap>(*service, *id, response, get_logger());
          if (result.success) PublishMosaic();
        });
      });
}

void MappingNode::Step() {
  try {
    const Stamp at = now().nanoseconds();
    const auto fix = logic_->Step(at);
    if (!fix) return;
    fixes_.Publish(*fix);
    if (at - mosaic_at_ < mosaic_period_ && at >= mosaic_at_) return;
    mosaic_at_ = at;
    PublishMosaic();
  } catch (const std::exception& error) {  // ROS ends, or the saved map cannot be read
    RCLCPP_ERROR(get_logger(), "%s", error.what());
  }
}

void MappingNode::PublishMosaic() {
  const CeilingGrid preview = logic_->Preview();
  if (preview.width == 0) return;
  nav_msgs::msg::OccupancyGrid grid = ToOccupancyGrid(preview);
  grid.header.stamp = ToTime(now().nanoseconds());
  grid.header.frame_id = parameters_.map_frame;
  grid.info.map_load_time = grid.header.stamp;
  ceiling_map_->publish(grid);
}

}  // namespace ceilmap_ros

RCLCPP_COMPONENTS_REGISTER_NODE(ceilmap_ros::MappingNode)
