#include "app/files/bag_estimate.hpp"

#include "app/bags/mcap_writer.hpp"
#include "app/bags/message_encoding.hpp"
#include "app/bags/message_types.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

bags::OdometryMessage OdometryAt(double stamp_s, double variance) {
  bags::OdometryMessage message;
  message.header = {bags::Nanoseconds(stamp_s), "odom"};
  message.child_frame_id = "base_link";
  message.pose.translation = {stamp_s, 2, 0};
  for (const std::size_t i : {0U, 7U, 35U}) message.pose_covariance.at(i) = variance;
  return message;
}

class BagEstimate : public testing::Test {
 protected:
  std::filesystem::path Write(const std::vector<std::string>& topics,
                              const std::vector<bags::OdometryMessage>& messages) {
    bags::McapWriter writer(folder_ / "t.mcap");
    for (const std::string& topic : topics) {
      const auto channel = writer.Add(topic, bags::kOdometryType);
      std::int64_t time_ns = 0;
      for (const auto& message : messages) writer.Write(channel, ++time_ns, bags::Encode(message));
    }
    writer.Commit();
    return folder_ / "t.mcap";
  }

  void ExpectRefused(const std::filesystem::path& file, const std::string& text) {
    try {
      (void)ReadEstimate(file);
      FAIL();
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(), file.string() + text);
    }
  }

  support::TestFolder folder_;
};

TEST_F(BagEstimate, OdometryOfOtherPrograms) {
  const Estimate estimate = ReadEstimate(Write({"/odom"}, {OdometryAt(5, 0.25), OdometryAt(6, 4)}));
  ASSERT_EQ(estimate.poses.size(), 2U);
  EXPECT_EQ(estimate.poses[1].stamp_s, 6);
  EXPECT_EQ(estimate.poses[1].position, Eigen::Vector3d(6, 2, 0));
  EXPECT_EQ(estimate.headings.size(), 2U);
  ASSERT_EQ(estimate.covariances.size(), 2U);
  EXPECT_EQ(*estimate.covariances[1], Eigen::Matrix3d(4 * Eigen::Matrix3d::Identity()));
  EXPECT_TRUE(estimate.frames_of_status.empty());
}

TEST_F(BagEstimate, ACovarianceOfZerosIsNotKnown) {
  const Estimate none = ReadEstimate(Write({"/odom"}, {OdometryAt(5, 0), OdometryAt(6, 0)}));
  EXPECT_TRUE(none.covariances.empty());
  const Estimate one = ReadEstimate(Write({"/odom"}, {OdometryAt(5, 0), OdometryAt(6, 1)}));
  ASSERT_EQ(one.covariances.size(), 2U);
  EXPECT_FALSE(one.covariances[0]);
  EXPECT_TRUE(one.covariances[1]);
}

TEST_F(BagEstimate, TheTopicOfTheTrajectoryIsPreferred) {
  EXPECT_EQ(ReadEstimate(Write({"/odom", "/pose"}, {OdometryAt(5, 0)})).poses.size(), 1U);
}

TEST_F(BagEstimate, FaultsAreNamed) {
  ExpectRefused(Write({"/a", "/b"}, {OdometryAt(5, 0)}),
                ": has poses on the topics /a, /b; give a bag with one of them");
  ExpectRefused(Write({}, {}),
                ": has no topic of type geometry_msgs/msg/PoseWithCovarianceStamped or "
                "nav_msgs/msg/Odometry");
  ExpectRefused(Write({"/a"}, {}), ": holds no poses");
  ExpectRefused(Write({"/a"}, {OdometryAt(5, 0), OdometryAt(5, 0)}),
                ": timestamp 5.000000 is not later than 5.000000 before it");
  bags::OdometryMessage turned = OdometryAt(5, 0);
  turned.pose.rotation = {0, 0, 0, 0};
  ExpectRefused(Write({"/a"}, {turned}),
                ": the pose at 5.000000 s is not finite, or its quaternion not of unit length");
}

}  // namespace
}  // namespace ceilmap::files
