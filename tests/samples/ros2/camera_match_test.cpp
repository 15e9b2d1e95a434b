#include "ceilmap_ros/logic/camera_match.hpp"

#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "ceilmap_ros/logic/rig_state.hpp"
#include "tests/samples/ros2/lab_drive.hpp"

namespace ceilmap_ros {
namespace {

CameraFacts LabCamera() {
  CameraFacts camera;
  camera.width = 640;
  camera.height = 480;
  camera.distortion_model = "plumb_bob";
  camera.d = {0, 0, 0, 0, 0};
  camera.k = {457.007362, 0, 319.5, 0, 457.007362, 239.5, 0, 0, 1};
  return camera;
}

TEST(CameraMatchTest, TheRigsOwnCalibrationAgrees) {
  const auto lens = LabDrive::Rig().up->camera;
  EXPECT_EQ(Mismatch(lens, LabCamera()), std::nullopt);
  CameraFacts binned = LabCamera();
  binned.width = 1280;
  binned.height = 960;
  binned.k = {914.014724, 0, 639.5, 0, 914.014724, 479.5, 0, 0, 1};
  binned.binning_x = binned.binning_y = 2;
  EXPECT_EQ(Mismatch(lens, binned), std::nullopt);
  EXPECT_EQ(LensOf(binned).width_px, 640);
  EXPECT_EQ(Mismatch(lens, CameraFacts{}), std::nullopt) << "not calibrated";
}

TEST(CameraMatchTest, AnotherCalibrationIsNamed) {
  const auto lens = LabDrive::Rig().up->camera;
  CameraFacts camera = LabCamera();
  camera.k[0] = camera.k[4] = 500;
  // The corner: 400 px from the centre times 500 / 457 - 1.
  EXPECT_EQ(Mismatch(lens, camera),
            "camera_info differs from the rig by up to 37.6 px of 640 px; calibrate again, or set "
            "camera_from_info");
  camera = LabCamera();
  camera.d[0] = -0.1;
  EXPECT_TRUE(Mismatch(lens, camera));
  camera = LabCamera();
  camera.distortion_model = "thin_prism";
  EXPECT_EQ(Mismatch(lens, camera),
            "camera_info: distortion_model = thin_prism, must be plumb_bob, rational_polynomial or "
            "equidistant");
}

TEST(CameraMatchTest, ImpossibleValuesAreRefused) {
  const auto refusal = [](const CameraFacts& camera) -> std::string {
    try {
      (void)LensOf(camera);
    } catch (const ceilmap::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({}),
            "camera_info has no calibration (K is zero); calibrate the camera, or set "
            "camera_from_info to false to use that of the rig");
  CameraFacts camera = LabCamera();
  camera.d.pop_back();
  EXPECT_EQ(refusal(camera), "camera_info: D has 4 coefficients, must be 5 for plumb_bob");
  camera = LabCamera();
  camera.region_of_interest = true;
  EXPECT_EQ(refusal(camera),
            "camera_info has a region of interest; let the camera send whole images");
  camera = LabCamera();
  camera.k[4] = -1;
  EXPECT_NE(refusal(camera), "");
  camera = LabCamera();
  camera.width = 0;
  EXPECT_NE(refusal(camera), "");
}

TEST(RigStateTest, TakesSizesAndCalibration) {
  Batch batch;
  batch.frame.grey = cv::Mat(240, 320, CV_8UC1);
  batch.camera = LabCamera();
  batch.camera->k[0] = batch.camera->k[4] = 480;
  RigState own(LabDrive::Rig(), false);
  EXPECT_TRUE(own.Ready());
  EXPECT_TRUE(own.Update(batch));
  EXPECT_NEAR(own.Get().up->camera.fx, 457.007362 / 2, 1e-9);
  EXPECT_NE(own.CameraMismatch(), "");
  batch.camera.reset();
  EXPECT_FALSE(own.Update(batch)) << "of the same size";
  batch.camera = LabCamera();
  EXPECT_FALSE(own.Update(batch));
  EXPECT_EQ(own.CameraMismatch(), "");

  RigState published(LabDrive::Rig(), true);
  EXPECT_FALSE(published.Ready());
  batch.camera.reset();
  (void)published.Update(batch);
  EXPECT_FALSE(published.Ready());
  batch.camera = LabCamera();
  batch.camera->k[0] = batch.camera->k[4] = 480;
  EXPECT_TRUE(published.Update(batch));
  EXPECT_TRUE(published.Ready());
  EXPECT_NEAR(published.Get().up->camera.fx, 240, 1e-9);

  batch.camera.reset();
  batch.frame.grey = cv::Mat(100, 320, CV_8UC1);
  EXPECT_THROW(published.Update(batch), ceilmap::InputError);
  EXPECT_EQ(published.Get().up->camera.height_px, 240) << "as before";
}

TEST(RigStateTest, NeedsAnUpwardCamera) {
  try {
    const RigState state({}, false);
    FAIL();
  } catch (const ceilmap::InputError& error) {
    EXPECT_STREQ(error.what(), "the rig has no camera 'up'; add it under cameras");
  }
}

}  // namespace
}  // namespace ceilmap_ros
