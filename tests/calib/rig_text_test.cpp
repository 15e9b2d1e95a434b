#include "calib/rig_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "calib/base/error.hpp"
#include "calib/rig.hpp"

namespace ceilmap::calib {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kCameras = R"(cameras:
  up:
    type: pinhole   # a comment
    image_width: 640
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [457, 0, 319.5, 0, 457, 239.5, 0, 0, 1]}
    distortion_model: plumb_bob
    distortion_coefficients: {rows: 1, cols: 5, data: [-0.1, 0.02, 0, 0, 0]}
)";
const std::string kPose = R"(    base_link_to_camera:
      frame: up_optical_frame
      translation: [0, 0, 0.4]
      rotation_xyzw: [0, 0, 0.707106781, 0.707106781]
)";

Eigen::Isometry3d Mount() {
  Eigen::Isometry3d T_base_up = Eigen::Isometry3d::Identity();
  T_base_up.linear() = (Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX()) *
                        Eigen::AngleAxisd(0.5 * std::numbers::pi + 0.1, Eigen::Vector3d::UnitZ()))
                           .toRotationMatrix();
  T_base_up.translation() << 0, -0.012, 0.45;
  return T_base_up;
}

RigValues Values(double axle_m, double ceiling_m) {
  RigValues values;
  values.axle_behind_mast_m = axle_m;
  values.ceiling_height_m = ceiling_m;
  values.T_base_up = Mount();
  return values;
}

TEST(RigText, SetsTheReadoutTimeOfTheUpwardCamera) {
  const std::string text = "a: 0.1\nh: 2.4\n" + kCameras + kPose;
  RigValues values;
  values.up_readout_time_s = -0.0215;
  EXPECT_EQ(ParseRig(ChangeRig(text, "r.yaml", values, "r.yaml"), "r.yaml").up->readout_time_s,
            -0.0215);
  const std::string known = text + "    readout_time_s: 0.01\n";
  EXPECT_EQ(ParseRig(ChangeRig(known, "r.yaml", values, "r.yaml"), "r.yaml").up->readout_time_s,
            -0.0215);
  EXPECT_EQ(CompleteRig(known, "r.yaml", values), known);
  EXPECT_EQ(ParseRig(ChangeRig(known, "r.yaml", {}, "r.yaml"), "r.yaml").up->readout_time_s, 0.01);
}

TEST(RigText, ChangesWhatIsGivenAndKeepsTheRest) {
  const std::string text = "robot: \"one\"\na: 0.1\nd: null\nh: 2.4\n" + kCameras + kPose;
  const std::string changed = ChangeRig(text, "r.yaml", Values(0.14, 2.6), "new.yaml");
  const Rig rig = ParseRig(changed, "new.yaml");
  EXPECT_DOUBLE_EQ(rig.axle_behind_mast_m, 0.14);
  EXPECT_DOUBLE_EQ(rig.ceiling_height_m, 2.6);
  EXPECT_TRUE(rig.up->T_base_cam.isApprox(Mount(), 1e-8));
  EXPECT_EQ(rig.robot, "one");
  EXPECT_DOUBLE_EQ(rig.up->camera.distortion[0], -0.1);
  EXPECT_THAT(changed, HasSubstr("frame: up_optical_frame"));
}

TEST(RigText, FillsInOnlyWhatIsMissing) {
  const std::string whole = "a: 0.1\nh: 2.4  # by tape\n" + kCameras + kPose;
  EXPECT_EQ(CompleteRig(whole, "r.yaml", Values(0.2, 3.0)), whole);
  const Rig rig =
      ParseRig(CompleteRig("a: 0.1\n" + kCameras, "r.yaml", Values(0.2, 3.0)), "r.yaml");
  EXPECT_DOUBLE_EQ(rig.axle_behind_mast_m, 0.1);
  EXPECT_DOUBLE_EQ(rig.ceiling_height_m, 3.0);
  EXPECT_TRUE(rig.up->T_base_cam.isApprox(Mount(), 1e-8));
}

TEST(RigText, CamerasThatAreNotThereAreNotAdded) {
  const std::string text = "a: 0.1\nh: 2.4\n" + kCameras + kPose;
  RigValues values;
  values.T_base_forward = Mount();
  EXPECT_THAT(ChangeRig(text, "r.yaml", values, "n.yaml"), Not(HasSubstr("forward")));
}

TEST(RigText, PathsCountFromTheNewFolder) {
  const std::string text =
      "a: 0.1\nh: 2.4\ncameras:\n  up:\n    type: pinhole\n    camera_info: up.yaml\n" + kPose;
  EXPECT_THAT(ChangeRig(text, "/robot/r.yaml", {}, "/robot/new/r.yaml"),
              HasSubstr("camera_info: ../up.yaml"));
  EXPECT_THAT(ChangeRig(text, "/robot/r.yaml", {}, "/robot/n.yaml"),
              HasSubstr("camera_info: up.yaml"));
}

TEST(RigText, AddsAMirrorCamera) {
  RigValues values;
  values.omni = {{{241.5, 238}, 40, 220}, 480, 470};
  const std::string text = "a: 0.1\nh: 2.4\n" + kCameras + kPose;
  const Rig rig = ParseRig(ChangeRig(text, "r.yaml", values, "n.yaml"), "n.yaml");
  ASSERT_TRUE(rig.omni && rig.omni->mirror_ring);
  EXPECT_EQ(rig.omni->camera.Size(), cv::Size(480, 470));
  EXPECT_DOUBLE_EQ(rig.omni->mirror_ring->centre_px.x(), 241.5);
  EXPECT_DOUBLE_EQ(rig.omni->mirror_ring->outer_radius_px, 220);
}

TEST(RigText, AMirrorOfKnownShapeKeepsIt) {
  const std::string text = R"(a: 0.1
h: 2.4
cameras:
  omni:
    type: hyperbolic_mirror
    image_width: 480
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [500, 0, 239.5, 0, 500, 239.5, 0, 0, 1]}
    distortion_model: none
    mirror: {A: 0.03, B: 0.04, C: 0.05, rim_radius: 0.04, rim_radius_px: 200, horizon_radius_px: 120}
)" + kPose;
  RigValues values;
  values.omni = {{{241.5, 238}, 40, 202}, 480, 480};
  const Rig rig = ParseRig(ChangeRig(text, "r.yaml", values, "n.yaml"), "n.yaml");
  ASSERT_TRUE(rig.omni && rig.omni->mirror);
  EXPECT_DOUBLE_EQ(rig.omni->mirror->A_m, 0.03);
  EXPECT_DOUBLE_EQ(rig.omni->mirror->rim_radius_px, 202);
  EXPECT_NEAR(rig.omni->mirror->horizon_radius_px, 121.2, 1e-9);
  EXPECT_DOUBLE_EQ(rig.omni->camera.fx, 505);
  EXPECT_DOUBLE_EQ(rig.omni->camera.cx, 241.5);
  EXPECT_DOUBLE_EQ(rig.omni->camera.cy, 238);
}

TEST(RigText, WhereAValueCannotBePutIsSaid) {
  RigValues values;
  values.omni = {{{100, 100}, 30, 90}, 201, 201};
  const auto message = [&](const std::string& text) -> std::string {
    try {
      (void)ChangeRig(text, "r.yaml", values, "n.yaml");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("cameras: {omni: camera}\n"),
            "r.yaml: values cannot be put into it: operator[] call on a scalar (key: \"type\"); "
            "correct it there, or give a rig file (format: calib/README.md)");
  EXPECT_NE(message("cameras:\n  omni: {type: hyperbolic_mirror, camera_matrix: {}, mirror: {}}\n"),
            "");
}

TEST(RigText, WhatIsNoRigIsRefused) {
  EXPECT_THROW(ChangeRig("- 1\n", "r.yaml", {}, "n.yaml"), InputError);
  EXPECT_THROW(CompleteRig("", "r.yaml", {}), InputError);
  EXPECT_THROW(RigOfCameraInfo("no-such-file.yaml"), InputError);
}

}  // namespace
}  // namespace ceilmap::calib
