#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "calib/base/degrees.hpp"
#include "mapping/odometry.hpp"
#include "tests/mapping/depth_drive.hpp"

namespace ceilmap::mapping {
namespace {

using registration::synthetic::SyntheticDepth;
using synthetic::CentredView;
using synthetic::DepthImage;
using synthetic::DepthParams;

TEST(OdometryDepth, DrivesUnderACeilingWithTwoHeights) {
  const SyntheticDepth ceiling(1.35);
  const calib::CeilingView view = CentredView();
  Odometry odometry(view, {}, DepthParams(view));
  Pose2 truth;
  double largest = 0;
  int keyframes = 0;
  int with_heights = 0;
  for (int i = 0; i < 45; ++i) {
    const cv::Mat image = DepthImage(ceiling, view, truth, i);
    const OdometryStep step = odometry.Process(image, i, 0.1 * i);
    ASSERT_EQ(step.pose.status, graph::TrackingStatus::kTracking) << i;
    const Pose2 off = truth.Inverse() * step.pose.T_map_base;
    largest = std::max(largest, std::hypot(off.x, off.y));
    EXPECT_LT(std::abs(off.yaw), 0.2 * kRadPerDeg) << i;
    keyframes += step.new_keyframe ? 1 : 0;
    with_heights += step.new_keyframe && step.new_keyframe->heights ? 1 : 0;
    truth = truth * Pose2{0.06, 0, (i < 20 ? 0 : 2) * kRadPerDeg};
  }
  EXPECT_LT(largest, 0.03);  // of 2.6 m; one plane: lost, or the steps of the strips, 1.35 times
  EXPECT_GE(keyframes, 5);
  EXPECT_GE(with_heights, keyframes - 1);  // the first one is measured afterwards
}

TEST(OdometryDepth, LaterFramesCorrectTheScaleOfTheFirst) {
  // Most of the image hangs below the plane, so that the first frames follow the strips.
  const SyntheticDepth ceiling(1.35, 0.62);
  const calib::CeilingView view = CentredView();
  Odometry odometry(view, {}, DepthParams(view));
  std::vector<double> ratios;  // of the travelled distance to the true one
  double first_error = 0;
  for (int i = 0; i < 14; ++i) {
    const Pose2 truth{0.005 * i * i, 0, 0};
    const cv::Mat image = DepthImage(ceiling, view, truth, i);
    const OdometryStep step = odometry.Process(image, i, 0.1 * i);
    ASSERT_EQ(step.pose.status, graph::TrackingStatus::kTracking) << i;
    if (step.pose.keyframe_id != 0) break;
    for (double& ratio : ratios) ratio *= step.registration.rescaled;
    if (i > 1) ratios.push_back(step.pose.T_map_base.x / truth.x);
    if (i > 1) first_error = std::max(first_error, std::abs(ratios.back() - 1));
  }
  ASSERT_GT(ratios.size(), 5U);
  EXPECT_GT(first_error, 0.12);
  for (const double ratio : ratios) EXPECT_NEAR(ratio, 1, 0.06);
}

TEST(OdometryDepth, OnePlaneStaysOnePlane) {
  const SyntheticDepth ceiling(1.35, 0.0);
  const calib::CeilingView view = CentredView();
  Odometry odometry(view, {}, DepthParams(view));
  Pose2 truth;
  for (int i = 0; i < 12; ++i) {
    const OdometryStep step = odometry.Process(DepthImage(ceiling, view, truth, i), i, 0.1 * i);
    ASSERT_EQ(step.pose.status, graph::TrackingStatus::kTracking) << i;
    EXPECT_FALSE(step.registration.heights) << i;
    EXPECT_FALSE(step.new_keyframe && step.new_keyframe->heights) << i;
    truth = truth * Pose2{0.08, 0, 1 * kRadPerDeg};
  }
}

}  // namespace
}  // namespace ceilmap::mapping
