#include "ceilmap_ros/logic/map_to_odom.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "calib/base/error.hpp"

namespace ceilmap_ros {
namespace {

using robot::TrackingStatus;

TEST(MapToOdomTest, ComposesToThePose) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-3, 3);
  for (int i = 0; i < 50; ++i) {
    const Pose2 T_map_base{uniform(random), uniform(random), uniform(random)};
    const Pose2 T_odom_base{uniform(random), uniform(random), uniform(random)};
    const auto result =
        ComputeMapToOdom(kSecond, T_map_base, {OdometryAnswer::Kind::kKnown, T_odom_base}, {});
    ASSERT_TRUE(result);
    const Pose2 composed = result->T_map_odom * T_odom_base;
    EXPECT_NEAR(composed.x, T_map_base.x, 1e-12);
    EXPECT_NEAR(composed.y, T_map_base.y, 1e-12);
    EXPECT_NEAR(ceilmap::WrapAngle(composed.yaw - T_map_base.yaw), 0, 1e-12);
  }
}

TEST(MapToOdomTest, AHandComputedCase) {
  // The robot stands at (2, 1) on the map and looks along y; the wheels say (1, 0), along x. The
  // origin of odom is 1 behind the robot: at (2, 0) on the map, and its x is the map's y.
  MapToOdomOptions params;
  params.transform_tolerance_s = 0.25;
  const auto result = ComputeMapToOdom(
      4 * kSecond, {2, 1, std::numbers::pi / 2}, {OdometryAnswer::Kind::kKnown, {1, 0, 0}}, params);
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->T_map_odom.x, 2, 1e-12);
  EXPECT_NEAR(result->T_map_odom.y, 0, 1e-12);
  EXPECT_NEAR(result->T_map_odom.yaw, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(result->valid_until, 4 * kSecond + kSecond / 4);
}

TEST(MapToOdomTest, NothingWithoutOdometry) {
  for (const auto kind : {OdometryAnswer::Kind::kNone,
                          OdometryAnswer::Kind::kNotYet,
                          OdometryAnswer::Kind::kTooOld,
                          OdometryAnswer::Kind::kGap}) {
    EXPECT_FALSE(ComputeMapToOdom(kSecond, {}, {kind, {}}, {}));
  }
}

TEST(MapToOdomTest, APredictedPoseIsSureWhileItsCovarianceIsSmall) {
  robot::Estimate estimate;
  estimate.pose.covariance.diagonal() << 0.09 * 0.09, 0.09 * 0.09, 0.04 * 0.04;
  estimate.status = TrackingStatus::kPredicted;
  EXPECT_TRUE(SurePose(estimate, {}));
  estimate.pose.covariance(2, 2) = 0.06 * 0.06;
  EXPECT_FALSE(SurePose(estimate, {}));
  estimate.pose.covariance.diagonal() << 0.11 * 0.11, 0.11 * 0.11, 0.04 * 0.04;
  EXPECT_FALSE(SurePose(estimate, {}));
  estimate.status = TrackingStatus::kTracking;
  EXPECT_TRUE(SurePose(estimate, {}));
  for (const auto status : {TrackingStatus::kLost, TrackingStatus::kAmbiguous}) {
    estimate.status = status;
    estimate.pose.covariance.setZero();
    EXPECT_FALSE(SurePose(estimate, {}));
  }
}

TEST(MapToOdomTest, ParametersAreChecked) {
  MapToOdomOptions params;
  params.Validate();
  params.transform_tolerance_s = 0;
  try {
    params.Validate();
    FAIL();
  } catch (const ceilmap::InputError& error) {
    EXPECT_STREQ(error.what(), "transform_tolerance = 0, must be > 0");
  }
  params = {};
  params.predicted_sigma_rad = -1;
  EXPECT_THROW(params.Validate(), ceilmap::InputError);
}

}  // namespace
}  // namespace ceilmap_ros
