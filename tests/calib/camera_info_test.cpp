#include "calib/camera_info.hpp"

#include <gmock/gmock.h>

namespace ceilmap::calib {
namespace {

CameraInfo TestInfo() {
  CameraInfo info;
  info.name = "up \"1\"";
  info.lens = {640, 480, 457.0073621, 458.1, 319.123456789012, 239.5, {-0.25, 0.0625, 1e-5, -2e-4}};
  info.rectified = {400, 401, 318, 240};
  info.remarks = {"a remark"};
  return info;
}

Lens ReadBack(const CameraInfo& info) {
  return ParseCameraInfo(YamlValue::Parse(FormatCameraInfo(info), "up.yaml", "a camera_info file"));
}

TEST(CameraInfo, IsReadBackAsItWasWritten) {
  CameraInfo info = TestInfo();
  const std::vector<std::pair<LensModel, std::array<double, 8>>> lenses = {
      {LensModel::kPlumbBob, info.lens.distortion},
      {LensModel::kRational, {0.2, -0.01, 1e-3, -2e-3, 0.001, 0.4, 0.01, 0.001}},
      {LensModel::kEquidistant, {0.05, -0.01, 0.002, -1e-5}}};
  for (const auto& [model, distortion] : lenses) {
    info.lens.model = model;
    info.lens.distortion = distortion;
    const Lens lens = ReadBack(info);
    EXPECT_EQ(lens.model, model);
    EXPECT_EQ(lens.Size(), cv::Size(640, 480));
    EXPECT_EQ(lens.Values(), info.lens.Values());
    EXPECT_EQ(lens.distortion, distortion);
  }
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
