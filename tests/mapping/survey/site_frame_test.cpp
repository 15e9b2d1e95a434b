#include "mapping/survey/site_frame.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace ceilmap::survey {
namespace {

SiteFrame QuarterTurn() {
  SiteFrame site;
  site.S_site_map = {{100, 200, std::numbers::pi / 2}, 2};
  site.centre_map = {1, 1};
  site.sigma_position_m = 0.01;
  return site;
}

TEST(SiteFrame, TransformsAPose) {
  const PoseWithCovariance pose = ToSite(QuarterTurn(), {{3, 1, 0.5}});
  EXPECT_NEAR(pose.pose.x, 98, 1e-12);   // -2 y
  EXPECT_NEAR(pose.pose.y, 206, 1e-12);  // 2 x
  EXPECT_NEAR(pose.pose.yaw, 0.5 + std::numbers::pi / 2, 1e-12);
}

TEST(SiteFrame, TurnsAndScalesTheCovariance) {
  SiteFrame site = QuarterTurn();
  site.sigma_position_m = 0;
  PoseWithCovariance pose{{3, 1, 0.5}};
  pose.covariance.diagonal() << 1, 4, 0.1;
  pose.covariance(0, 2) = pose.covariance(2, 0) = 0.2;
  const Eigen::Matrix3d covariance = ToSite(site, pose).covariance;
  EXPECT_NEAR(covariance(0, 0), 16, 1e-12);
  EXPECT_NEAR(covariance(1, 1), 4, 1e-12);
  EXPECT_NEAR(covariance(1, 2), 0.4, 1e-12);
  EXPECT_NEAR(covariance(2, 2), 0.1, 1e-12);
}

TEST(SiteFrame, AddsTheErrorOfTheAlignment) {
  SiteFrame site = QuarterTurn();
  site.sigma_yaw_rad = 0.001;
  site.sigma_scale = 0.002;
  // 5 m of the map from the centre along x: 10 m in the site along y.
  const Eigen::Matrix3d covariance = ToSite(site, {{6, 1, 0}}).covariance;
  EXPECT_NEAR(covariance(0, 0), 1e-4 + 1e-4, 1e-12);  // by yaw: 10 m * 0.001
  EXPECT_NEAR(covariance(1, 1), 1e-4 + 4e-4, 1e-12);  // by scale: 10 m * 0.002
  EXPECT_NEAR(covariance(2, 2), 1e-6, 1e-15);
  EXPECT_NEAR(covariance(0, 2), -10 * 1e-6, 1e-15);
}

TEST(SiteFrame, ToMapIsTheInverse) {
  const SiteFrame site = QuarterTurn();
  const Pose2 pose{3, 1, 0.5};
  const PoseWithCovariance back = ToMap(site, {ToSite(site, {pose}).pose});
  EXPECT_NEAR(back.pose.x, pose.x, 1e-12);
  EXPECT_NEAR(back.pose.y, pose.y, 1e-12);
  EXPECT_NEAR(back.pose.yaw, pose.yaw, 1e-12);
  EXPECT_NEAR(back.covariance(0, 0), 1e-4 / 4, 1e-12);
}

}  // namespace
}  // namespace ceilmap::survey
