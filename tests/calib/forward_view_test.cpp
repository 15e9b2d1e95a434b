#include "calib/forward_view.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>

#include "calib/base/error.hpp"

namespace ceilmap::calib {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFocal = 277;

/// 320 x 240 px along base x, then turned to the left by its yaw, raised by its pitch and rolled
/// about its own view, left side up.
MountedCamera ForwardCamera(double yaw_deg, double raised_deg = 0, double roll_deg = 0) {
  MountedCamera forward;
  forward.camera = {320, 240, kFocal, kFocal, 159.5, 119.5, {}};
  Eigen::Matrix3d R_ahead_cam;  // x right, y down, z ahead
  R_ahead_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  forward.T_base_cam.linear() = (AngleAxisd(yaw_deg * kRadPerDeg, Vector3d::UnitZ()) *
                                 AngleAxisd(-raised_deg * kRadPerDeg, Vector3d::UnitY()) *
                                 AngleAxisd(roll_deg * kRadPerDeg, Vector3d::UnitX()))
                                    .toRotationMatrix() *
                                R_ahead_cam;
  forward.T_base_cam.translation() = Vector3d(0.1, 0, 0.45);
  return forward;
}

/// Grey value of a wall that is infinitely far, by how far to the left and how high it stands, as
/// tangents.
double Wall(double left, double up) {
  return 128 + 50 * std::sin(17 * left + 3 * up) + 50 * std::cos(14 * up - 5 * left);
}

/// What a raw camera shows of that wall, which stands at a right angle to a direction of base.
cv::Mat RenderRaw(const MountedCamera& forward, double wall_yaw_rad) {
  const Lens& camera = forward.camera;
  cv::Mat raw(camera.Size(), CV_8UC1);
  for (int v = 0; v < raw.rows; ++v) {
    for (int u = 0; u < raw.cols; ++u) {
      Vector2d slope((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
      for (int step = 0; step < 20; ++step) {
        const auto pixel = camera.Project(slope.homogeneous());
        if (!pixel) break;
        slope.x() += (u - pixel->x()) / camera.fx;
        slope.y() += (v - pixel->y()) / camera.fy;
      }
      const Vector3d ray = AngleAxisd(-wall_yaw_rad, Vector3d::UnitZ()) *
                           (forward.T_base_cam.linear() * slope.homogeneous());
      raw.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(Wall(ray.y() / ray.x(), ray.z() / ray.x()));
    }
  }
  return raw;
}

/// Largest grey error over pixels with content of the image that is level by the view.
double WorstError(const ForwardView& view, const cv::Mat& rectified) {
  double worst = 0;
  for (int v = 0; v < rectified.rows; ++v) {
    for (int u = 0; u < rectified.cols; ++u) {
      if (!view.Mask().empty() && view.Mask().at<std::uint8_t>(v, u) == 0) continue;
      const double left = -(u - 159.5 - view.Horizon().x()) / view.FocalLength();
      const double up = -(v - 119.5 - view.Horizon().y()) / view.FocalLength();
      worst = std::max(worst, std::abs(rectified.at<std::uint8_t>(v, u) - Wall(left, up)));
    }
  }
  return worst;
}

TEST(ForwardView, ALevelCameraPassesItsImagesThrough) {
  const ForwardView view(ForwardCamera(0));
  EXPECT_EQ(view.Size(), cv::Size(320, 240));
  EXPECT_NEAR(view.FocalLength(), kFocal, 1e-12);
  EXPECT_NEAR(view.Horizon().norm(), 0, 1e-12);
  EXPECT_NEAR(view.Yaw(), 0, 1e-15);
  EXPECT_TRUE(view.Mask().empty());
  const cv::Mat raw(view.Size(), CV_8UC1, cv::Scalar(7));
  cv::Mat buffer;
  EXPECT_EQ(view.Rectify(raw, buffer).data, raw.data);
}

TEST(ForwardView, ARaisedCameraHasItsHorizonBelowTheCentre) {
  const ForwardView view(ForwardCamera(0, 10));
  EXPECT_NEAR(view.Horizon().x(), 0, 1e-9);
  EXPECT_NEAR(view.Horizon().y(), kFocal * std::tan(10 * kRadPerDeg), 1e-9);
  // Raised by 30 degrees the horizon is below the image.
  EXPECT_GT(ForwardView(ForwardCamera(0, 30)).Horizon().y(), 119.5);
  EXPECT_LT(ForwardView(ForwardCamera(0, -10)).Horizon().y(), 0);
}

TEST(ForwardView, ItsPrincipalPointIsKept) {
  MountedCamera forward = ForwardCamera(0);
  forward.camera.cx = 150;
  forward.camera.cy = 128;
  const ForwardView view(forward);
  EXPECT_NEAR((view.Horizon() - Vector2d(-9.5, 8.5)).norm(), 0, 1e-9);
}

TEST(ForwardView, YawIsCounterClockwiseWhateverElseTheMountDoes) {
  EXPECT_NEAR(ForwardView(ForwardCamera(12)).Yaw(), 12 * kRadPerDeg, 1e-12);
  EXPECT_NEAR(ForwardView(ForwardCamera(-7, 5, 3)).Yaw(), -7 * kRadPerDeg, 1e-12);
}

TEST(ForwardView, TakesOutDistortionUnequalFocalLengthsAndTheMountsTilt) {
  MountedCamera forward = ForwardCamera(5, 6, -3);
  forward.camera.fy = 280;
  forward.camera.distortion = {-0.2, 0.05, 0.001, -0.0007, 0.01};
  const ForwardView view(forward);
  EXPECT_NEAR(view.FocalLength(), std::sqrt(277 * 280.0), 1e-9);
  ASSERT_FALSE(view.Mask().empty());
  const int content = cv::countNonZero(view.Mask());
  EXPECT_GT(content, 320 * 240 * 8 / 10);
  cv::Mat buffer;
  const cv::Mat rectified = view.Rectify(RenderRaw(forward, view.Yaw()), buffer);
  EXPECT_LT(WorstError(view, rectified), 2.5);
  cv::Mat blank;
  rectified.copyTo(blank, ~view.Mask());
  EXPECT_EQ(cv::countNonZero(blank), 0);
}

TEST(ForwardView, RefusesOtherImages) {
  const ForwardView view(ForwardCamera(0));
  cv::Mat buffer;
  EXPECT_THAT([&] { (void)view.Rectify(cv::Mat(240, 321, CV_8UC1), buffer); },
              testing::ThrowsMessage<InputError>(
                  "image of 321 x 240 pixels, must be 320 x 240 and 8-bit grey; use the rig of "
                  "the camera that took it"));
}

TEST(ForwardView, RefusesCamerasThatDoNotPointForward) {
  const char* const message =
      "forward camera: its optical axis must point forward (within 45 deg); correct the camera's "
      "pose in the rig";
  for (const MountedCamera& camera : {ForwardCamera(46),
                                      ForwardCamera(90),
                                      ForwardCamera(180),
                                      ForwardCamera(0, 46),
                                      ForwardCamera(0, 90),
                                      ForwardCamera(0, -90),
                                      ForwardCamera(35, 35)}) {
    EXPECT_THAT([&] { ForwardView{camera}; }, testing::ThrowsMessage<InputError>(message));
  }
  EXPECT_NO_THROW(ForwardView{ForwardCamera(44)});
  EXPECT_NO_THROW(ForwardView{ForwardCamera(0, -44)});
}

TEST(ForwardView, RefusesCamerasThatCannotBe) {
  const char* const message =
      "forward camera: image size and focal lengths must be > 0; correct the rig";
  const auto expect_refusal = [&](const std::function<void(Lens&)>& spoil) {
    MountedCamera forward = ForwardCamera(0);
    spoil(forward.camera);
    EXPECT_THAT([&] { ForwardView{forward}; }, testing::ThrowsMessage<InputError>(message));
  };
  expect_refusal([](Lens& camera) { camera.width_px = 1; });
  expect_refusal([](Lens& camera) { camera.height_px = 0; });
  expect_refusal([](Lens& camera) { camera.fx = 0; });
  expect_refusal([](Lens& camera) { camera.fy = -3; });
  expect_refusal([](Lens& camera) { camera.fx = std::numeric_limits<double>::quiet_NaN(); });
}

}  // namespace
}  // namespace ceilmap::calib
