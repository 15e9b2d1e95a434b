#include "app/bags/message_types.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "app/bags/mcap_writer.hpp"

namespace ceilmap::bags {
namespace {

TEST(RosChannel, HasTheQualityOfServiceOfRosbag2) {
  const McapChannel channel = RosChannel("/map", kGridType, Durability::kTransientLocal);
  EXPECT_EQ(channel.topic, "/map");
  EXPECT_EQ(channel.message_encoding, "cdr");
  EXPECT_EQ(channel.schema_name, "nav_msgs/msg/OccupancyGrid");
  EXPECT_EQ(channel.schema_encoding, "ros2msg");
  EXPECT_EQ(channel.metadata,
            (std::map<std::string, std::string>{{"offered_qos_profiles",
                                                 "- history: 1\n"
                                                 "  depth: 1\n"
                                                 "  reliability: 1\n"
                                                 "  durability: 1\n"
                                                 "  deadline:\n"
                                                 "    sec: 9223372036\n"
                                                 "    nsec: 854775807\n"
                                                 "  lifespan:\n"
                                                 "    sec: 9223372036\n"
                                                 "    nsec: 854775807\n"
                                                 "  liveliness: 1\n"
                                                 "  liveliness_lease_duration:\n"
                                                 "    sec: 9223372036\n"
                                                 "    nsec: 854775807\n"
                                                 "  avoid_ros_namespace_conventions: false"}}));
  const std::string volatile_profile =
      RosChannel("/a", kImageType, Durability::kVolatile).metadata.at("offered_qos_profiles");
  EXPECT_THAT(volatile_profile, testing::HasSubstr("depth: 10\n"));
  EXPECT_THAT(volatile_profile, testing::HasSubstr("durability: 2\n"));
}

TEST(MessageDefinition, ContainsEachTypeOnce) {
  const std::string line(80, '=');
  EXPECT_EQ(MessageDefinition(kPathType),
            "std_msgs/Header header\n"
            "geometry_msgs/PoseStamped[] poses\n" +
                line +
                "\nMSG: std_msgs/Header\n"
                "builtin_interfaces/Time stamp\n"
                "string frame_id\n" +
                line +
                "\nMSG: builtin_interfaces/Time\n"
                "int32 sec\n"
                "uint32 nanosec\n" +
                line +
                "\nMSG: geometry_msgs/PoseStamped\n"
                "std_msgs/Header header\n"
                "geometry_msgs/Pose pose\n" +
                line +
                "\nMSG: geometry_msgs/Pose\n"
                "geometry_msgs/Point position\n"
                "geometry_msgs/Quaternion orientation\n" +
                line +
                "\nMSG: geometry_msgs/Point\n"
                "float64 x\n"
                "float64 y\n"
                "float64 z\n" +
                line +
                "\nMSG: geometry_msgs/Quaternion\n"
                "float64 x 0\n"
                "float64 y 0\n"
                "float64 z 0\n"
                "float64 w 1\n");
}

}  // namespace
}  // namespace ceilmap::bags
