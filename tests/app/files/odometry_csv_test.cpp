#include "app/files/odometry_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "calib/base/error.hpp"

namespace ceilmap::files {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(OdometryCsv, ReadsPoses) {
  const OdometryRecording recording =
      ParseOdometry("timestamp,x,y,yaw_deg,sigma\n1,0.5,-1,90,3\n2,1,2,450,3\n", "w.csv");
  ASSERT_EQ(recording.poses.size(), 2U);
  EXPECT_TRUE(recording.speeds.empty());
  EXPECT_DOUBLE_EQ(recording.poses[0].T_odom_base.y, -1);
  EXPECT_NEAR(recording.poses[1].T_odom_base.yaw, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(recording.FirstStamp(), 1);
  EXPECT_EQ(recording.LastStamp(), 2);
}

TEST(OdometryCsv, ReadsSpeeds) {
  const OdometryRecording recording =
      ParseOdometry("timestamp,v,omega\n1,0.5,-0.1\n2,0.6,0.2\n", "w.csv");
  ASSERT_EQ(recording.speeds.size(), 2U);
  EXPECT_DOUBLE_EQ(recording.speeds[0].velocity.linear_m_s.x(), 0.5);
  EXPECT_DOUBLE_EQ(recording.speeds[1].velocity.yaw_rad_s, 0.2);
}

TEST(OdometryCsv, ReadsTum) {
  const OdometryRecording recording =
      ParseOdometry("# timestamp tx, ty\n1 2 3 0 0 0 1 0\n2 2 3 0 0 0 0 1\n", "w.tum");
  ASSERT_EQ(recording.poses.size(), 2U);
  EXPECT_NEAR(std::abs(recording.poses[0].T_odom_base.yaw), std::numbers::pi, 1e-12);
}

TEST(OdometryCsv, SortsRows) {
  const OdometryRecording recording =
      ParseOdometry("timestamp,v,omega\n1,1,0\n3,3,0\n2,2,0\n2,7,0\n4,4,0\n", "w.csv");
  ASSERT_EQ(recording.speeds.size(), 4U);
  EXPECT_EQ(recording.out_of_order, 2);
  EXPECT_EQ(recording.speeds[1].velocity.linear_m_s.x(), 2);
}

TEST(OdometryCsv, NamesFileLineAndCause) {
  const auto parse = [](const char* text) {
    return [text] { (void)ParseOdometry(text, "w.csv"); };
  };
  EXPECT_THAT(parse("timestamp,x,y,yaw_deg\n1,a,0,0\n"),
              ThrowsMessage<InputError>(HasSubstr("w.csv:2")));
  EXPECT_THAT(parse("timestamp,x,y\n1,0,0\n2,0,0\n"),
              ThrowsMessage<InputError>(HasSubstr("yaw_deg")));
  EXPECT_THAT(parse("time,left,right\n1,0,0\n"),
              ThrowsMessage<InputError>(HasSubstr("timestamp,v,omega")));
  EXPECT_THAT(parse("timestamp,v,omega\n1,0,nan\n"),
              ThrowsMessage<InputError>(HasSubstr("w.csv:2")));
  EXPECT_THAT(parse("timestamp,v,omega\n1,0,0\n"),
              ThrowsMessage<InputError>(HasSubstr("fewer than two")));
  EXPECT_THAT(parse("1 2 3\n"), ThrowsMessage<InputError>(HasSubstr("w.csv:1")));
  EXPECT_THROW((void)ParseOdometry("", "w.csv"), InputError);
}

TEST(OdometryCsv, ReadsAGyro) {
  const GyroRecording gyro = ParseGyro("timestamp,omega_z\n1,0.1\n1.5,-0.1\n", "g.csv");
  ASSERT_EQ(gyro.samples.size(), 2U);
  EXPECT_DOUBLE_EQ(gyro.samples[1].yaw_rate_rad_s, -0.1);
  EXPECT_THROW((void)ParseGyro("timestamp,omega\n1,2\n2,3\n", "g.csv"), InputError);
}

}  // namespace
}  // namespace ceilmap::files
