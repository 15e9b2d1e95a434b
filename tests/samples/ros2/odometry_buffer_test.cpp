#include "ceilmap_ros/logic/odometry_buffer.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace ceilmap_ros {
namespace {

using Kind = OdometryAnswer::Kind;

TEST(OdometryBufferTest, InterpolatesAlongTheArc) {
  OdometryBuffer buffer;
  EXPECT_EQ(buffer.At(kSecond).kind, Kind::kNone);
  EXPECT_FALSE(buffer.Newest());
  // A quarter of a circle of radius 1 to the left, in 0.4 s.
  buffer.Add({kSecond, {5, 5, 0}});
  buffer.Add({kSecond + 400'000'000, {6, 6, std::numbers::pi / 2}});
  const OdometryAnswer half = buffer.At(kSecond + 200'000'000);
  ASSERT_TRUE(half.Known());
  EXPECT_NEAR(half.T_odom_base.x, 5 + std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(half.T_odom_base.y, 6 - std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(half.T_odom_base.yaw, std::numbers::pi / 4, 1e-9);
  const OdometryAnswer last = buffer.At(kSecond + 400'000'000);
  ASSERT_TRUE(last.Known());
  EXPECT_EQ(last.T_odom_base.x, 6);
  EXPECT_EQ(buffer.Newest(), kSecond + 400'000'000);
}

TEST(OdometryBufferTest, ExtrapolatesNothing) {
  OdometryBuffer buffer;
  buffer.Add({10 * kSecond, {}});
  buffer.Add({10 * kSecond + 100, {1, 0, 0}});
  EXPECT_EQ(buffer.At(10 * kSecond - 1).kind, Kind::kTooOld);
  EXPECT_EQ(buffer.At(10 * kSecond + 101).kind, Kind::kNotYet);
  buffer.Add({11 * kSecond, {2, 0, 0}});
  EXPECT_EQ(buffer.At(10 * kSecond + 101).kind, Kind::kGap);
  EXPECT_STREQ(ToString(Kind::kGap), "odometry has a gap at the image");
}

TEST(OdometryBufferTest, KeepsTenSeconds) {
  OdometryBuffer buffer;
  for (int i = 0; i <= 200; ++i) buffer.Add({i * (kSecond / 10), {0.1 * i, 0, 0}});
  EXPECT_EQ(buffer.At(10 * kSecond - 1).kind, Kind::kTooOld);
  EXPECT_NEAR(buffer.At(10 * kSecond).T_odom_base.x, 10, 1e-9);
  buffer.Clear();
  EXPECT_EQ(buffer.At(15 * kSecond).kind, Kind::kNone);
}

TEST(StreamOrderTest, TellsAResetFromDisorder) {
  StreamOrder order;
  EXPECT_EQ(order.Take(5 * kSecond), StreamOrder::Step::kNext);
  EXPECT_EQ(order.Take(5 * kSecond), StreamOrder::Step::kOutOfOrder);
  EXPECT_EQ(order.Take(4 * kSecond + 1), StreamOrder::Step::kOutOfOrder);
  EXPECT_EQ(order.Last(), 5 * kSecond);
  EXPECT_EQ(order.Take(4 * kSecond), StreamOrder::Step::kReset);
  EXPECT_EQ(order.Take(4 * kSecond + 1), StreamOrder::Step::kNext);
}

TEST(TimelineTest, NeverDecreasesAndIsExact) {
  constexpr Stamp kFirst = 1'700'000'000'123'456'789;
  Timeline timeline;
  EXPECT_EQ(timeline.At(kFirst), 0);
  EXPECT_DOUBLE_EQ(timeline.At(kFirst + 1), 1e-9);
  EXPECT_DOUBLE_EQ(timeline.At(kFirst + 5 * kSecond), 5);
  timeline.Restart(3);
  EXPECT_DOUBLE_EQ(timeline.At(3), 15);
  EXPECT_DOUBLE_EQ(timeline.At(3 + kSecond), 16);
}

}  // namespace
}  // namespace ceilmap_ros
