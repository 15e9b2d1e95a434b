#include "calib/camera_info.hpp"

#include <gmock/gmock.h>

namespace ceilmap::calib {
namespace {

CameraInfo TestInfo() {
  CameraInfo info;
  info.name = "up \"1\"";
  info.size = {640, 480};
  info.pinhole = {457.0073621, 458.1, 319.123456789012, 239.5};
  info.distortion_model = "plumb_bob";
  info.distortion = {-0.25, 0.0625, 1e-5, -2e-4, 0};
  info.rectified = {400, 401, 318, 240};
  info.remarks = {"a remark"};
  return info;
}

TEST(CameraInfo, IsReadBackAsItWasWritten) {
  const CameraInfo info = TestInfo();
  const std::string text = FormatCameraInfo(info);
  const Lens camera = ParseCameraInfo(YamlValue::Parse(text, "up.yaml", "a camera_info file"));
  EXPECT_EQ(camera.width_px, 640);
  EXPECT_EQ(camera.height_px, 480);
  EXPECT_EQ(camera.fx, info.pinhole[0]);
  EXPECT_EQ(camera.fy, info.pinhole[1]);
  EXPECT_EQ(camera.cx, info.pinhole[2]);
  EXPECT_EQ(camera.cy, info.pinhole[3]);
  EXPECT_THAT(camera.Coefficients(), testing::ElementsAreArray(info.distortion));
}

// As camera_calibration_parsers has it.
TEST(CameraInfo, HasTheFormOfRos) {
  EXPECT_EQ(FormatCameraInfo(TestInfo()),
            "# a remark\n"
            "image_width: 640\n"
            "image_height: 480\n"
            "camera_name: \"up \\\"1\\\"\"\n"
            "camera_matrix:\n"
            "  rows: 3\n"
            "  cols: 3\n"
            "  data: [457.0073621, 0, 319.123456789012, 0, 458.1, 239.5, 0, 0, 1]\n"
            "distortion_model: plumb_bob\n"
            "distortion_coefficients:\n"
            "  rows: 1\n"
            "  cols: 5\n"
            "  data: [-0.25, 0.0625, 1e-05, -0.0002, 0]\n"
            "rectification_matrix:\n"
            "  rows: 3\n"
            "  cols: 3\n"
            "  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
            "projection_matrix:\n"
            "  rows: 3\n"
            "  cols: 4\n"
            "  data: [400, 0, 318, 0, 0, 401, 240, 0, 0, 0, 1, 0]\n");
}

}  // namespace
}  // namespace ceilmap::calib
