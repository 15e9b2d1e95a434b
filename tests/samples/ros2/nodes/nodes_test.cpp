/// The nodes as a container makes them, against the stand-ins of ROS 2: from messages to messages.

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <ceilmap_ros/srv/load_map.hpp>
#include <ceilmap_ros/srv/save_map.hpp>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <nav_msgs/msg/occupancy_grid.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp_components/register_node_macro.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

#include "tests/samples/ros2/lab_drive.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap_ros {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using nav_msgs::msg::OccupancyGrid;
using stand_in::Bus;
using tf2_msgs::msg::TFMessage;

constexpr int kFrames = 30;

builtin_interfaces::msg::Time TimeOf(Stamp stamp) {
  builtin_interfaces::msg::Time time;
  time.sec = static_cast<std::int32_t>(stamp / kSecond);
  time.nanosec = static_cast<std::uint32_t>(stamp % kSecond);
  return time;
}
Stamp StampOf(const builtin_interfaces::msg::Time& time) {
  return time.sec * kSecond + time.nanosec;
}
geometry_msgs::msg::Pose PoseOf(const Pose2& T) {
  geometry_msgs::msg::Pose pose;
  pose.position.x = T.x;
  pose.position.y = T.y;
  pose.orientation.z = std::sin(T.yaw / 2);
  pose.orientation.w = std::cos(T.yaw / 2);
  return pose;
}
template <typename Rotation>
double YawOf(const Rotation& q) {
  return 2 * std::atan2(q.z, q.w);
}

class NodesTest : public testing::Test {
 protected:
  NodesTest() { Bus::Get().Clear(); }
  ~NodesTest() override {
    node_.reset();
    Bus::Get().Clear();
  }

  void Start(const std::string& name, std::vector<rclcpp::Parameter> parameters) {
    parameters.emplace_back("rig", kSamples + "lab-map/rig.yaml");
    node_ = stand_in::NodeFactories().at("ceilmap_ros::" + name)(
        rclcpp::NodeOptions().parameter_overrides(parameters));
  }

  /// Odometry and image of a frame; colours, as a camera sends them.
  void Send(int i) const {
    const Stamp stamp = LabDrive::StampOf(i);
    Bus::Get().SetNow(stamp + kSecond / 50);
    nav_msgs::msg::Odometry odometry;
    odometry.header.stamp = TimeOf(stamp);
    odometry.header.frame_id = "odom";
    odometry.child_frame_id = "base_link";
    odometry.pose.pose = PoseOf(drive_.T_odom_base(i));
    ASSERT_TRUE(Bus::Get().Send("/odom", odometry));
    cv::Mat colours;
    cv::cvtColor(drive_.Image(i), colours, cv::COLOR_GRAY2BGR);
    sensor_msgs::msg::Image image;
    image.header.stamp = TimeOf(stamp);
    image.encoding = "bgr8";
    image.width = static_cast<std::uint32_t>(colours.cols);
    image.height = static_cast<std::uint32_t>(colours.rows);
    image.step = static_cast<std::uint32_t>(colours.step);
    image.data.assign(colours.datastart, colours.dataend);
    ASSERT_TRUE(Bus::Get().Send("/ceiling/image", image));
  }
  /// Sends a frame and waits for its pose.
  std::shared_ptr<const PoseWithCovarianceStamped> PoseAt(int i) const {
    Send(i);
    return Bus::Get().WaitFor<PoseWithCovarianceStamped>("/pose", [&](const auto& pose) {
      return StampOf(pose.header.stamp) == LabDrive::StampOf(i);
    });
  }
  static DiagnosticStatus Status() {
    Bus::Get().Tick();
    return Bus::Get().All<DiagnosticArray>("/diagnostics").back()->status.at(0);
  }

  /// The transform of a frame, with the pose that it gives.
  void ExpectTransform(int i) const {
    const Stamp valid_until = LabDrive::StampOf(i) + kSecond / 2;
    const auto message = Bus::Get().WaitFor<TFMessage>("/tf", [&](const auto& tf) {
      return StampOf(tf.transforms.at(0).header.stamp) == valid_until;
    });
    ASSERT_TRUE(message) << i;
    const auto& transform = message->transforms[0];
    EXPECT_EQ(transform.header.frame_id, "map");
    EXPECT_EQ(transform.child_frame_id, "odom");
    const auto& t = transform.transform.translation;
    const Pose2 T_map_odom{t.x, t.y, YawOf(transform.transform.rotation)};
    const Pose2 T_map_base = T_map_odom * drive_.T_odom_base(i);
    EXPECT_LT(Distance(T_map_base, drive_.T_map_base(i)), 0.02) << i;
    EXPECT_LT(Turn(T_map_base, drive_.T_map_base(i)), 0.01) << i;
  }

  static const LabDrive drive_;
  std::shared_ptr<rclcpp::Node> node_;
};

const LabDrive NodesTest::drive_(kFrames);

/// Maps the drive, and leaves the node as it was when the map was saved.
class NodesOnAMapTest : public NodesTest {
 protected:
  void MapAndSave() {
    Start("MappingNode", {{"map", map_.string()}, {"mosaic_period", 1.0}});
    for (int i = 0; i < kFrames; ++i) ASSERT_TRUE(PoseAt(i)) << i;
    ExpectTransform(kFrames - 1);
    srv::SaveMap::Request request;
    const auto response = Bus::Get().Call<srv::SaveMap>("/ceilmap_mapping/save_map", request);
    EXPECT_TRUE(response.success);
    EXPECT_EQ(response.message, map_.string() + ": 30 images; mapping has ended");
  }

  ceilmap::support::TempFolder folder_;
  std::filesystem::path map_ = folder_ / "lab.gpkg";
};

TEST_F(NodesOnAMapTest, MappingThenLocalization) {
  MapAndSave();
  EXPECT_EQ(Bus::Get().QosOf("/ceiling_map"), "1 reliable transient_local");
  EXPECT_GE(Bus::Get().All<OccupancyGrid>("/ceiling_map").size(), 3U);
  EXPECT_EQ(Status().level, DiagnosticStatus::OK);
  node_.reset();
  Bus::Get().Clear();

  Start("LocalizationNode", {{"map", map_.string()}});
  const auto grid = Bus::Get().WaitFor<OccupancyGrid>(
      "/ceiling_map", [](const auto& message) { return !message.data.empty(); });
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->header.frame_id, "map");
  EXPECT_EQ(grid->data.size(), std::size_t{grid->info.width} * grid->info.height);
  EXPECT_NEAR(grid->info.resolution, 0.0048, 0.0005);
  EXPECT_LT(grid->info.origin.position.x, 0);

  PoseWithCovarianceStamped start;
  start.header.stamp = TimeOf(LabDrive::StampOf(10));
  start.header.frame_id = "odom";
  start.pose.pose = PoseOf(drive_.T_map_base(10));
  start.pose.covariance[0] = start.pose.covariance[7] = 0.01;
  start.pose.covariance[35] = 0.005;
  ASSERT_TRUE(Bus::Get().Send("/initialpose", start));
  EXPECT_EQ(Bus::Get().Log().back(),
            "WARN initialpose is in the frame 'odom', must be 'map'; set RViz's fixed frame");
  start.header.frame_id = "map";
  ASSERT_TRUE(Bus::Get().Send("/initialpose", start));
  for (int i = 10; i < 14; ++i) {
    const auto pose = PoseAt(i);
    ASSERT_TRUE(pose) << i;
    EXPECT_EQ(pose->header.frame_id, "map");
    const Pose2 T{
        pose->pose.pose.position.x, pose->pose.pose.position.y, YawOf(pose->pose.pose.orientation)};
    EXPECT_LT(Distance(T, drive_.T_map_base(i)), 0.02) << i;
    EXPECT_GT(pose->pose.covariance[0], 0);
    EXPECT_GT(pose->pose.covariance[35], 0);
    EXPECT_EQ(pose->pose.covariance[14], 0);
    ExpectTransform(i);
  }
  const DiagnosticStatus status = Status();
  EXPECT_EQ(status.name, "/ceilmap_localization");
  EXPECT_EQ(status.hardware_id, "robot 1");
  EXPECT_EQ(status.message, "tracking");
  EXPECT_EQ(status.level, DiagnosticStatus::OK);

  srv::LoadMap::Request request;
  request.path = (folder_ / "none.gpkg").string();
  const auto refused = Bus::Get().Call<srv::LoadMap>("/ceilmap_localization/load_map", request);
  EXPECT_FALSE(refused.success);
  EXPECT_NE(refused.message.find("none.gpkg"), std::string::npos);
  ASSERT_TRUE(PoseAt(14)) << "on the map before";
  request.path = map_.string();
  const auto loaded = Bus::Get().Call<srv::LoadMap>("/ceilmap_localization/load_map", request);
  EXPECT_TRUE(loaded.success);
  EXPECT_EQ(loaded.message, map_.string() + " is loaded");
  EXPECT_TRUE(Bus::Get()
                  .Call<std_srvs::srv::Trigger>("/ceilmap_localization/relocalize",
                                                std_srvs::srv::Trigger::Request())
                  .success);
}

TEST_F(NodesTest, ANodeWithoutMapSaysSo) {
  Start("LocalizationNode", {});
  Send(0);
  EXPECT_EQ(Status().message, "no map is loaded; call load_map");
  EXPECT_EQ(Status().level, DiagnosticStatus::ERROR);
  sensor_msgs::msg::Image image;
  image.encoding = "yuv422";
  ASSERT_TRUE(Bus::Get().Send("/ceiling/image", image));
  EXPECT_EQ(Bus::Get().Log().back(),
            "WARN the encoding 'yuv422' is not supported, must be mono8, mono16, rgb8, bgr8, "
            "rgba8, bgra8 or bayer_*8; set it in the camera's driver");
}

TEST_F(NodesTest, TheCalibrationOfTheDriverIsCompared) {
  ceilmap::support::TempFolder folder;
  Start("MappingNode", {{"map", (folder / "lab.gpkg").string()}});
  sensor_msgs::msg::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.d.assign(5, 0);
  info.k = {500, 0, 319.5, 0, 500, 239.5, 0, 0, 1};
  ASSERT_TRUE(Bus::Get().Send("/ceiling/camera_info", info));
  ASSERT_TRUE(PoseAt(0));
  EXPECT_EQ(Status().message,
            "camera_info differs from the rig by up to 37.6 px of 640 px; calibrate again, or set "
            "camera_from_info");
}

TEST_F(NodesTest, BadParametersAreRefused) {
  const auto refusal = [&](const std::string& node, std::vector<rclcpp::Parameter> parameters) {
    try {
      Start(node, std::move(parameters));
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal("MappingNode", {}), "the parameter 'map' is empty; set NAME.gpkg");
  EXPECT_EQ(refusal("LocalizationNode", {{"rig", std::string()}}),
            "the parameter 'rig' is empty; set rig.yaml");
  EXPECT_EQ(refusal("LocalizationNode", {{"transform_tolerance", -1.0}}),
            "transform_tolerance = -1, must be > 0");
  EXPECT_EQ(refusal("MappingNode",
                    {{"map", std::string("a.gpkg")}, {"origin", std::vector<double>{1, 2}}}),
            "the parameter 'origin' must have three values: x, y (m), yaw (deg)");
}

/// The files of config/ give each parameter that a node has, with its type.
TEST_F(NodesTest, TheConfigurationsFit) {
  for (const auto& [file, node, component] :
       {std::tuple{"localization.yaml", "ceilmap_localization", "LocalizationNode"},
        std::tuple{"mapping.yaml", "ceilmap_mapping", "MappingNode"}}) {
    SCOPED_TRACE(file);
    ceilmap::support::TempFolder folder;
    const YAML::Node parameters =
        YAML::LoadFile(kSamples + "ros2/config/" + file)["/**"][node]["ros__parameters"];
    std::vector<rclcpp::Parameter> overrides;
    std::vector<std::string> names;
    for (const auto& entry : parameters) {
      const auto name = entry.first.as<std::string>();
      const YAML::Node& value = entry.second;
      names.push_back(name);
      if (name == "rig") continue;  // Start gives it
      if (name == "map" && std::string(component) == "MappingNode") {
        overrides.emplace_back(name, (folder / "a.gpkg").string());
      } else if (value.IsSequence()) {
        overrides.emplace_back(name, value.as<std::vector<double>>());
      } else if (value.Tag() == "!" || value.Scalar().empty()) {
        overrides.emplace_back(name, value.as<std::string>());
      } else if (value.Scalar() == "true" || value.Scalar() == "false") {
        overrides.emplace_back(name, value.as<bool>());
      } else if (value.Scalar().find_first_not_of("0123456789") == std::string::npos) {
        overrides.emplace_back(name, std::int64_t{value.as<int>()});
      } else if (value.Scalar().find_first_not_of("0123456789.") == std::string::npos) {
        overrides.emplace_back(name, value.as<double>());
      } else {
        overrides.emplace_back(name, value.as<std::string>());
      }
    }
    Start(component, overrides);
    std::vector<std::string> declared = node_->Declared();
    std::sort(declared.begin(), declared.end());
    std::sort(names.begin(), names.end());
    EXPECT_EQ(names, declared);
    node_.reset();
    Bus::Get().Clear();
  }
}

}  // namespace
}  // namespace ceilmap_ros
