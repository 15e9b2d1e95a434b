#include "mapping/mosaic/row_times.hpp"

#include <gtest/gtest.h>

#include <string>

#include "calib/ceiling_view.hpp"
#include "calib/rig.hpp"

namespace ceilmap::mosaic {
namespace {

std::string RigText(const std::string& readout) {
  return R"(robot: r
a: 0.1
d: null
h: 2.5
cameras:
  up:
    type: pinhole
    image_width: 640
    image_height: 480
    camera_matrix: {rows: 3, cols: 3, data: [318, 0, 319.5, 0, 318, 239.5, 0, 0, 1]}
    distortion_model: equidistant
    distortion_coefficients: {rows: 1, cols: 4, data: [-0.028, 0.0065, -0.0032, 0.0004]}
    base_link_to_camera: {translation: [0, 0, 0.22], rotation_xyzw: [0, 0, 0.707106781, 0.707106781]}
)" + (readout.empty() ? "" : "    readout_time_s: " + readout + "\n");
}

store::MapMetadata MetadataOf(const std::string& rig_yaml) {
  const calib::Rig rig = calib::ParseRig(rig_yaml, "rig.yaml");
  store::MapMetadata metadata;
  metadata.rig_yaml = rig_yaml;
  metadata.ceiling_height_m = rig.ceiling_height_m;
  metadata.view_size = calib::CeilingView(*rig.up, rig.ceiling_height_m).Size();
  return metadata;
}

TEST(RowTimes, AreThoseOfTheRawRows) {
  const store::MapMetadata metadata = MetadataOf(RigText("0.025"));
  const cv::Mat times = RowTimes(metadata);
  ASSERT_EQ(times.size(), metadata.view_size);
  const calib::Rig rig = calib::ParseRig(metadata.rig_yaml, "rig.yaml");
  const calib::CeilingView view(*rig.up, rig.ceiling_height_m);
  for (const cv::Point at : {cv::Point(5, 3), cv::Point(101, 57), cv::Point(203, 170)}) {
    const auto raw = view.RawPixel(Eigen::Vector2d(at.x, at.y));
    ASSERT_TRUE(raw.has_value());
    EXPECT_NEAR(times.at<float>(at), 0.025 * (raw->y() / 479 - 0.5), 2e-5) << at;
  }
  // The view lies on the same axis as the raw image, whose top row is first.
  EXPECT_LT(times.at<float>(10, 100), 0);
}

TEST(RowTimes, AreNoneWhereRowsAreExposedAtOnce) {
  EXPECT_TRUE(RowTimes(MetadataOf(RigText(""))).empty());
  EXPECT_TRUE(RowTimes(MetadataOf(RigText("0.001"))).empty());
  EXPECT_TRUE(RowTimes(store::MapMetadata()).empty());
}

TEST(RowTimes, AreNoneForAnotherViewAndAnUnknownRig) {
  store::MapMetadata metadata = MetadataOf(RigText("0.025"));
  metadata.view_size.width += 2;
  EXPECT_TRUE(RowTimes(metadata).empty());
  metadata = MetadataOf(RigText("0.025"));
  metadata.rig_yaml = "cameras: {up: {type: later}}";
  EXPECT_TRUE(RowTimes(metadata).empty());
}

}  // namespace
}  // namespace ceilmap::mosaic
