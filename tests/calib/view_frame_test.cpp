#include "calib/view_frame.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "calib/base/degrees.hpp"

namespace ceilmap::calib {
namespace {

MountedCamera Level(const Lens& lens) {
  MountedCamera up;
  up.camera = lens;
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation().z() = 0.4;
  return up;
}

MountedCamera Fisheye(double focal_px) {
  return Level(Lens::WithoutDistortion(LensModel::kEquidistant, {640, 480}, focal_px));
}

TEST(UpwardFrame, OfAFisheyeHasNoMorePixelsThanItsImage) {
  // The corners are 400 px / 201 px = 114 deg from the axis; the view ends at 65 deg.
  const ViewFrame frame = UpwardFrame(Fisheye(201));
  EXPECT_NEAR(frame.focal_px, 400 / std::tan(65 * kRadPerDeg), 0.5);
  EXPECT_EQ(frame.size, cv::Size(640, 480));
  EXPECT_EQ(frame.principal_px, Eigen::Vector2d(320, 240));
}

TEST(UpwardFrame, LosesResolutionWithItsAngle) {
  // Corners 55 deg from the axis, half way between 45 and 65 deg: half the diagonal is the mean of
  // f tan(55 deg) and 400 px.
  const double focal_px = 400 / (55 * kRadPerDeg);
  const ViewFrame frame = UpwardFrame(Fisheye(focal_px));
  const double slope = std::tan(55 * kRadPerDeg);
  EXPECT_NEAR(frame.focal_px, (focal_px * slope + 400) / 2 / slope, 1);
}

TEST(UpwardFrame, EndsWhereTheRawImageEnds) {
  // 319.5 px at f = 800 px: 0.3994 rad, 800 tan(0.3994) = 337.6 px; 239.5 px: 246.8 px.
  const ViewFrame frame = UpwardFrame(Fisheye(800));
  EXPECT_EQ(frame.size, cv::Size(674, 492));
  EXPECT_EQ(frame.principal_px, Eigen::Vector2d(337, 246));
}

TEST(UpwardFrame, OfATiltedCameraIsCutWhereItsImageEnds) {
  MountedCamera up = Fisheye(401);
  // Nose down by 15 deg: the camera looks ahead, its image ends earlier behind the robot.
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(15 * kRadPerDeg, Eigen::Vector3d::UnitY()).toRotationMatrix() *
      up.T_base_cam.linear();
  const ViewFrame frame = UpwardFrame(up);
  // The corners are 400 / 401 rad = 57.154 deg from the axis: half the diagonal has 0.6077 * 400 +
  // 0.3923 * 401 tan(57.154 deg) = 486.7 px, half the height 292.0 px: to the front in full. The
  // focal length is 486.7 px / tan(57.154 deg) = 314.2 px. The raw image's end is 239.5 / 401 rad =
  // 34.220 deg from the axis: behind, 19.220 deg from the vertical, 109.5 px.
  EXPECT_NEAR(frame.focal_px, 314.2, 1);
  EXPECT_NEAR(frame.principal_px.y(), 292, 1);
  EXPECT_NEAR(frame.size.height, 292 + 1 + 109, 2);
  const auto raw =
      RawPixel(up.camera,
               up.T_base_cam.linear().transpose() *
                   Eigen::AngleAxisd(UpwardYaw(up.T_base_cam.linear()), Eigen::Vector3d::UnitZ())
                       .toRotationMatrix(),
               frame,
               frame.principal_px);
  ASSERT_TRUE(raw);  // the vertical is 15 deg from the axis, towards the robot's back: below
  EXPECT_NEAR(raw->x(), 319.5, 1e-9);
  EXPECT_NEAR(raw->y(), 239.5 + 401 * 15 * kRadPerDeg, 1e-9);
}

TEST(UpwardFrame, KeepsTheSizeOfAPlumbBobCamera) {
  MountedCamera up = Fisheye(300);
  up.camera.model = LensModel::kPlumbBob;
  up.camera.distortion[0] = -0.2;
  up.camera.cx = 310;
  const ViewFrame frame = UpwardFrame(up);
  EXPECT_EQ(frame.size, cv::Size(640, 480));
  EXPECT_EQ(frame.focal_px, 300);
  EXPECT_EQ(frame.principal_px, Eigen::Vector2d(310, 239.5));
}

TEST(UpwardFrame, IsWhatTheRigStates) {
  MountedCamera up = Fisheye(200);
  up.view = ViewChoice{90 * kRadPerDeg, {}};  // 2 f = 400 px, in the ratio of the raw image
  ViewFrame frame = UpwardFrame(up);
  EXPECT_EQ(frame.size, cv::Size(400, 300));
  EXPECT_EQ(frame.focal_px, 200);
  EXPECT_EQ(frame.principal_px, Eigen::Vector2d(199.5, 149.5));
  up.view = ViewChoice{90 * kRadPerDeg, cv::Size(800, 500)};
  frame = UpwardFrame(up);
  EXPECT_EQ(frame.size, cv::Size(800, 500));
  EXPECT_NEAR(frame.focal_px, 400, 1e-9);
  up.view = ViewChoice{{}, cv::Size(320, 240)};
  frame = UpwardFrame(up);
  EXPECT_EQ(frame.size, cv::Size(320, 240));
  EXPECT_EQ(frame.focal_px, 200);
}

}  // namespace
}  // namespace ceilmap::calib
