#include "app/recordings/bag_motion.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "app/recordings/wheel_inputs.hpp"
#include "tests/support/test_bag.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

constexpr double kAll = std::numeric_limits<double>::infinity();

/// x metres ahead, turned by 90 degrees to the left.
bags::OdometryMessage Odometry(std::int64_t stamp_ns, double x) {
  bags::OdometryMessage message;
  message.header = {stamp_ns, "odom"};
  message.child_frame_id = "base_link";
  message.pose = {{x, 0.5, 0}, {0, 0, std::sqrt(0.5), std::sqrt(0.5)}};
  message.linear = {0.25, 0, 0};
  message.angular = {0, 0, 0.125};
  return message;
}

class BagMotionTest : public testing::Test {
 protected:
  [[nodiscard]] std::string Bag() const { return (folder_ / "run.mcap").string(); }

  support::TestFolder folder_;
};

TEST_F(BagMotionTest, OdometryIsThePosesByTheirHeaders) {
  support::TestBag bag(Bag());
  for (int i = 0; i < 3; ++i) {
    const std::int64_t stamp_ns = support::kBagStartNs + i * support::kSecondNs / 2;
    bag.Write("/odom", bags::kOdometryType, stamp_ns + support::kSecondNs, Odometry(stamp_ns, i));
  }
  bag.Commit();
  const files::OdometryRecording odometry = ReadBagOdometry(Bag(), {});
  ASSERT_EQ(odometry.poses.size(), 3U);
  EXPECT_TRUE(odometry.speeds.empty());
  EXPECT_EQ(odometry.poses[1].stamp_s, support::kBagStartS + 0.5);
  EXPECT_DOUBLE_EQ(odometry.poses[2].T_odom_base.x, 2);
  EXPECT_DOUBLE_EQ(odometry.poses[2].T_odom_base.y, 0.5);
  EXPECT_NEAR(odometry.poses[2].T_odom_base.yaw, M_PI / 2, 1e-12);
  EXPECT_EQ(ReadBagOdometry(Bag(), {.stamp = BagStamp::kLog}).poses[1].stamp_s,
            support::kBagStartS + 1.5);
}

TEST_F(BagMotionTest, TheTwistIsUsedWhereThereIsNoPose) {
  support::TestBag bag(Bag());
  for (int i = 0; i < 3; ++i) {
    bags::OdometryMessage message = Odometry(support::kBagStartNs + i * support::kSecondNs, i);
    message.pose.rotation = {0, 0, 0, 0};
    bag.Write("/odom", bags::kOdometryType, support::kBagStartNs + i * support::kSecondNs, message);
  }
  bag.Commit();
  const files::OdometryRecording odometry = ReadBagOdometry(Bag(), {});
  ASSERT_EQ(odometry.speeds.size(), 3U);
  EXPECT_EQ(odometry.speeds[1].velocity.linear_m_s.x(), 0.25);
  EXPECT_EQ(odometry.speeds[1].velocity.yaw_rad_s, 0.125);
}

TEST_F(BagMotionTest, OfTransformsThoseToTheBaseCount) {
  support::TestBag bag(Bag());
  const auto link = [](const char* parent, const char* child, std::int64_t stamp_ns, double x) {
    return support::Link(parent, child, {x, 0, 0}, {0, 0, 0, 1}, stamp_ns);
  };
  for (int i = 0; i < 4; ++i) {
    const std::int64_t stamp_ns = support::kBagStartNs + i * support::kSecondNs;
    bag.Write("/tf",
              bags::kTransformsType,
              stamp_ns,
              std::vector{link("map", "odom", stamp_ns, 50),
                          link("odom", "base_footprint", stamp_ns, i),
                          link("base_footprint", "base_link", stamp_ns, 9),
                          link("other", "base_link", stamp_ns, 70)});
  }
  bag.Commit();
  const files::OdometryRecording odometry = ReadBagOdometry(Bag(), {.topic = "/tf"});
  ASSERT_EQ(odometry.poses.size(), 4U);
  EXPECT_EQ(odometry.poses[3].T_odom_base.x, 3);
}

TEST_F(BagMotionTest, SamplesAreReadAsTheyAreNeeded) {
  support::TestBag bag(Bag());
  for (int i = 0; i < 100; ++i) {
    bag.Write("/odom",
              bags::kOdometryType,
              support::kBagStartNs + i * support::kSecondNs,
              Odometry(support::kBagStartNs + i * support::kSecondNs, i));
  }
  bag.Commit();
  WheelInputs wheels(Bag(), {});
  EXPECT_TRUE(wheels.Odometry().Empty());
  std::vector<double> stamps;
  const auto add = [&stamps](const auto& sample) {
    stamps.push_back(sample.stamp_s - support::kBagStartS);
  };
  wheels.ReadTo(support::kBagStartS + 2.7, add);
  EXPECT_EQ(stamps, (std::vector<double>{0, 1, 2, 3}));
  EXPECT_EQ(wheels.Odometry().poses.size(), 5U);
  wheels.ReadTo(kAll, add);
  EXPECT_EQ(stamps.size(), 100U);
  EXPECT_EQ(wheels.OdometryName(), Bag() + ":/odom");
  EXPECT_TRUE(wheels.BagWarnings().empty());
}

TEST_F(BagMotionTest, WhatCannotBeUsedIsCounted) {
  support::TestBag bag(Bag());
  const auto write = [&](std::int64_t stamp_ns, double x) {
    bag.Write("/odom",
              bags::kOdometryType,
              support::kBagStartNs + stamp_ns,
              Odometry(support::kBagStartNs + stamp_ns, x));
  };
  write(0, 0);
  write(support::kSecondNs, 1);
  bag.Write("/odom",
            bags::kOdometryType,
            support::kBagStartNs + support::kSecondNs,
            Odometry(support::kBagStartNs + support::kSecondNs / 2, 7));
  write(2 * support::kSecondNs, std::numeric_limits<double>::quiet_NaN());
  write(3 * support::kSecondNs, 3);
  bag.Commit();
  WheelInputs wheels(Bag(), {});
  wheels.ReadTo(kAll, [](const auto&) {});
  EXPECT_EQ(wheels.Odometry().poses.size(), 3U);
  EXPECT_THAT(
      wheels.BagWarnings(),
      testing::ElementsAre(
          Bag() + ":/odom: 1 messages were not later than the one before, and were left out",
          Bag() + ":/odom: 1 messages are damaged or without a value, and were left out"));
}

TEST_F(BagMotionTest, TurnRatesAreAboutTheVerticalOfTheBase) {
  support::TestBag bag(Bag());
  // The sensor lies on its side: its y axis points down.
  bag.Write("/tf_static",
            bags::kTransformsType,
            support::kBagStartNs,
            std::vector{support::Link(
                "base_link", "imu_link", {}, {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)})});
  for (int i = 0; i < 2; ++i) {
    bag.Write("/imu",
              bags::kImuType,
              support::kBagStartNs + i * support::kSecondNs,
              bags::ImuMessage{{support::kBagStartNs + i * support::kSecondNs, "imu_link"},
                               {0.1, -0.3, 0.2}});
  }
  bag.Commit();
  WheelInputs wheels({}, Bag());
  wheels.ReadTo(kAll, [](const auto&) {});
  ASSERT_EQ(wheels.Gyro().samples.size(), 2U);
  EXPECT_NEAR(wheels.Gyro().samples[0].yaw_rate_rad_s, 0.3, 1e-12);
  EXPECT_TRUE(wheels.BagWarnings().empty());
}

TEST_F(BagMotionTest, AGyroWithoutATransformIsTakenToBeUpright) {
  support::TestBag bag(Bag());
  bag.Write("/imu",
            bags::kImuType,
            support::kBagStartNs,
            bags::ImuMessage{{support::kBagStartNs, "imu_link"}, {0.1, 0.3, 0.2}});
  bag.Commit();
  WheelInputs wheels({}, Bag());
  wheels.ReadTo(kAll, [](const auto&) {});
  EXPECT_EQ(wheels.Gyro().samples.at(0).yaw_rate_rad_s, 0.2);
  EXPECT_THAT(
      wheels.BagWarnings(),
      testing::ElementsAre(Bag() + ":/imu: /tf_static does not connect its frame imu_link with "
                                   "base_link; its axes are taken to be those of base_link"));
}

}  // namespace
}  // namespace ceilmap::recordings
