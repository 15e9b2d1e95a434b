#include "calib/robot_rig.hpp"

#include <gmock/gmock.h>

#include <functional>
#include <string>

#include "calib/base/error.hpp"
#include "calib/mirror_view.hpp"
#include "tests/calib/rig_text.hpp"

namespace ceilmap::calib {
namespace {

std::string ErrorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(FitUpCamera, LeavesACameraOfTheSameSize) {
  Rig rig = ParseRig(kRigText, "rig.yaml");
  EXPECT_FALSE(FitUpCamera(rig, "up.mp4", {640, 480}));
  EXPECT_EQ(rig.up->camera.Matrix(), cv::Matx33d(457, 0, 319.5, 0, 458, 239.5, 0, 0, 1));
}

TEST(FitUpCamera, ScalesAboutTheCornerOfTheImage) {
  Rig rig = ParseRig(kRigText, "rig.yaml");
  const auto scaling = FitUpCamera(rig, "up.mp4", {320, 240});
  ASSERT_TRUE(scaling);
  EXPECT_EQ(scaling->Text(),
            "the rig's camera 'up' has 640x480 px, up.mp4 320x240: its intrinsics are scaled by "
            "0.5");
  EXPECT_EQ(rig.up->camera.Size(), cv::Size(320, 240));
  EXPECT_EQ(rig.up->camera.Matrix(), cv::Matx33d(228.5, 0, 159.5, 0, 229, 119.5, 0, 0, 1));
  EXPECT_EQ(rig.up->camera.distortion, ParseRig(kRigText, "rig.yaml").up->camera.distortion);
}

TEST(FitUpCamera, ScalesTheStatedView) {
  Rig rig = ParseRig(kRigText, "rig.yaml");
  rig.up->view = ViewChoice{1.5, cv::Size(600, 400)};
  ASSERT_TRUE(FitUpCamera(rig, "up.mp4", {320, 240}));
  EXPECT_EQ(rig.up->view->size, cv::Size(300, 200));
  EXPECT_EQ(rig.up->view->field_of_view_rad, 1.5);
}

// A block of 2 x 2 pixels becomes one: its centre at (u + 0.5, v + 0.5) is the new pixel's centre.
TEST(ScaledTo, AgreesWithBlocksOfPixels) {
  const Lens camera{640, 480, 457, 458, 311.2, 236.9, {-0.12, 0.02, 0.001, -0.002, 0}};
  const Lens half = ScaledTo(camera, {320, 240});
  const Eigen::Vector3d p_cam(0.3, -0.2, 1.1);
  const Eigen::Vector2d whole_px = *camera.Project(p_cam);
  const Eigen::Vector2d half_px = *half.Project(p_cam);
  EXPECT_NEAR(whole_px.x(), 2 * half_px.x() + 0.5, 1e-9);
  EXPECT_NEAR(whole_px.y(), 2 * half_px.y() + 0.5, 1e-9);
}

TEST(FitUpCamera, AllowsSidesThatWereRounded) {
  Rig rig = ParseRig(kRigText, "rig.yaml");
  ASSERT_TRUE(FitUpCamera(rig, "up.mp4", {639, 480}));
  EXPECT_DOUBLE_EQ(rig.up->camera.fx, 457 * 639.0 / 640);
  EXPECT_DOUBLE_EQ(rig.up->camera.fy, 458);
  EXPECT_DOUBLE_EQ(rig.up->camera.cx, 319);
  Rig small = ParseRig(kRigText, "rig.yaml");
  EXPECT_TRUE(FitUpCamera(small, "up.mp4", {426, 320}));  // 426.67 x 320
}

TEST(FitUpCamera, RefusesOtherImages) {
  Rig rig = ParseRig(kRigText, "rig.yaml");
  const auto error = [&](cv::Size size) {
    return ErrorOf([&] { FitUpCamera(rig, "up.mp4", size); });
  };
  EXPECT_EQ(error({480, 640}),
            "up.mp4: images are 480x640 px, but camera 'up' of rig.yaml has 640x480 px; is the "
            "recording turned by 90 degrees?");
  EXPECT_EQ(error({240, 320}),
            "up.mp4: images are 240x320 px, but camera 'up' of rig.yaml has 640x480 px; is the "
            "recording turned by 90 degrees?");
  EXPECT_EQ(error({640, 360}),
            "up.mp4: images are 640x360 px, but camera 'up' of rig.yaml has 640x480 px; it is "
            "cropped or of another camera; use this recording's rig");
  EXPECT_THAT(error({640, 488}), testing::HasSubstr("it is cropped"));  // rows were added
  EXPECT_EQ(rig.up->camera.Size(), cv::Size(640, 480));
  rig.up.reset();
  EXPECT_EQ(error({640, 480}), "rig.yaml: has no camera 'up'; add it under cameras");
}

TEST(FitForwardCamera, ScalesThatCameraOnly) {
  Rig rig = ParseRig(kRigText, "rig.yaml");
  const auto scaling = FitForwardCamera(rig, "forward.mp4", {640, 480});
  ASSERT_TRUE(scaling);
  EXPECT_EQ(scaling->Text(),
            "the rig's camera 'forward' has 320x240 px, forward.mp4 640x480: its intrinsics are "
            "scaled by 2");
  EXPECT_DOUBLE_EQ(rig.forward->camera.fx, 554);
  EXPECT_EQ(rig.up->camera.fx, 457);
  EXPECT_EQ(rig.omni->camera.fx, 520);
}

// The panorama shows the same directions in both sizes.
TEST(FitOmniCamera, ScalesAMirrorOfKnownShape) {
  Rig rig = ParseRig(kRigText, "rig.yaml");
  const MirrorView whole(*rig.omni);
  ASSERT_TRUE(FitOmniCamera(rig, "omni.mp4", {240, 240}));
  EXPECT_DOUBLE_EQ(rig.omni->mirror->rim_radius_px, 0.5 * 225.623);
  EXPECT_DOUBLE_EQ(rig.omni->mirror->horizon_radius_px, 0.5 * 138.707);
  EXPECT_DOUBLE_EQ(*MirrorView(*rig.omni).HorizonRow(), *whole.HorizonRow());
}

TEST(FitOmniCamera, ScalesARingAndKeepsItInside) {
  Rig rig = ParseRig(kRigText, "rig.yaml");
  MountedCamera& omni = *rig.omni;
  omni.mirror.reset();
  omni.camera = {480, 480, 0, 0, 0, 0, {}};
  omni.mirror_ring = MirrorRing{{239.5, 240.5}, 60, 230};
  ASSERT_TRUE(FitOmniCamera(rig, "omni.mp4", {240, 240}));
  EXPECT_EQ(omni.mirror_ring->centre_px, Eigen::Vector2d(119.5, 120));
  EXPECT_DOUBLE_EQ(omni.mirror_ring->inner_radius_px, 30);
  EXPECT_DOUBLE_EQ(omni.mirror_ring->outer_radius_px, 115);

  omni.camera = {480, 480, 0, 0, 0, 0, {}};
  omni.mirror_ring = MirrorRing{{239.5, 239.5}, 60, 239.5};
  ASSERT_TRUE(FitOmniCamera(rig, "omni.mp4", {240, 240}));
  EXPECT_DOUBLE_EQ(omni.mirror_ring->outer_radius_px, 119.5);
  EXPECT_NO_THROW(MirrorView{omni});
}

}  // namespace
}  // namespace ceilmap::calib
