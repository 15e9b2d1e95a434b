#include "compensation/shutter_velocity.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap::compensation {
namespace {

constexpr double kFocalPx = 300;

calib::CeilingView View() {
  calib::MountedCamera up;
  up.camera = {640, 480, kFocalPx, kFocalPx, 319.5, 239.5, {}};
  up.readout_time_s = 0.02;
  return {up, 2.5};
}

Twist2 Turning(double yaw_rad_s) {
  return {Eigen::Vector2d::Zero(), yaw_rad_s};
}

class ShutterVelocityTest : public testing::Test {
 protected:
  ShutterVelocityTest() {
    velocity_.Add({0.05, {}});
    velocity_.Add({0.15, {}});
  }

  calib::CeilingView view_ = View();
  ShutterVelocity velocity_{view_};
};

TEST_F(ShutterVelocityTest, AnEvenMotionShowsNoTilt) {
  const ShutterVelocity::Estimate now = velocity_.With({0.25, {}}, 0.3);
  EXPECT_NEAR(now.velocity.yaw_rad_s, 0, 1e-12);
  EXPECT_NEAR(now.tilt_variance, 0, 1e-18);
}

// Half of a mean turn of 0.6 rad/s is added. In half the read-out it moves the corners, 400 px from
// the middle, as much as a tilt that moves them by its angle times 400^2 / 300 px.
TEST_F(ShutterVelocityTest, ATurnThatBeginsMayBeATilt) {
  const ShutterVelocity::Estimate now = velocity_.With({0.25, Turning(0.6)}, 0.3);
  EXPECT_NEAR(now.velocity.yaw_rad_s, 0.9, 1e-9);
  const double corner_px = 400 * 0.3 * 0.01;
  EXPECT_NEAR(std::sqrt(now.tilt_variance), corner_px * kFocalPx / (400 * 400), 2e-5);
  // Nothing is added by asking.
  EXPECT_NEAR(velocity_.At(0.3)->yaw_rad_s, 0, 1e-12);
}

TEST_F(ShutterVelocityTest, ExactIsWhatMovesTheRowsByLessThanAPartOfAPixel) {
  EXPECT_TRUE(velocity_.IsExact(Turning(0.5), Turning(0.55)));   // 0.2 px
  EXPECT_FALSE(velocity_.IsExact(Turning(0.5), Turning(0.62)));  // 0.5 px
}

TEST(ShutterVelocity, WithoutAMeasurementNothingIsKnown) {
  const calib::CeilingView view = View();
  const ShutterVelocity velocity(view);
  EXPECT_FALSE(velocity.At(1));
}

}  // namespace
}  // namespace ceilmap::compensation
