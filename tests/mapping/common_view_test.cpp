#include "mapping/common_view.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "tests/mapping/map_files.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::DriveUnder;
using synthetic::MapFiles;
using synthetic::MetadataOf;
using synthetic::OtherView;
using synthetic::SmallView;

std::string Refusal(const std::vector<NamedMap>& maps) {
  try {
    const CommonView view(maps);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

graph::MapGraph OneKeyframe(bool with_heights = false) {
  graph::MapGraph graph;
  graph.keyframes.resize(1);
  graph.keyframes.front().pose.keyframe_id = 0;
  if (with_heights) {
    auto field = std::make_shared<heights::HeightField>();
    field->grid = {2, 1};
    field->first_px = {-50, 20};
    field->step_px = {100, 10};
    field->cells.assign(2, {1.2F, 0.01F});
    graph.keyframes.front().heights = field;
  }
  return graph;
}

TEST(CommonView, MapsOfOneGeometryKeepTheirImages) {
  MapFiles files;
  files.Add("a", MetadataOf(SmallView()), OneKeyframe());
  files.Add("b", MetadataOf(SmallView()), OneKeyframe());
  const CommonView view(files.Maps());
  EXPECT_TRUE(view.Keeps(files.Maps()[1].map->Metadata()));
  EXPECT_EQ(view.Metadata().view_size, cv::Size(320, 240));
  const cv::Mat image(240, 320, CV_8UC1, cv::Scalar(9));
  EXPECT_EQ(view.Resample(image, files.Maps()[1].map->Metadata()).data, image.data);
}

TEST(CommonView, HasTheCoarsestScaleAndTheSmallestFootprint) {
  MapFiles files;
  files.Add("a", MetadataOf(OtherView()), OneKeyframe());  // 2.4 x 2.24 m at 8 mm
  files.Add("b", MetadataOf(SmallView()), OneKeyframe());  // 3.2 x 2.4 m at 10 mm
  const CommonView view(files.Maps());
  const store::MapMetadata& common = view.Metadata();
  EXPECT_DOUBLE_EQ(common.view_units_per_px, 0.01);
  EXPECT_EQ(common.view_size, cv::Size(240, 224));
  EXPECT_NEAR(common.view_focal_px * common.view_units_per_px, 1.6, 1e-9) << "of the reference";
  EXPECT_NEAR(common.T_base_view.y, OtherView().T_base_view().y, 1e-12);
  EXPECT_TRUE(common.view_mask.empty());
}

// What is drawn is what a camera with the common geometry would have seen.
TEST(CommonView, DrawsWhatACameraOfItsGeometrySees) {
  MapFiles files;
  files.Add("a", MetadataOf(SmallView()), OneKeyframe());
  files.Add("b", MetadataOf(OtherView()), OneKeyframe());
  const CommonView view(files.Maps());
  const Pose2 place{0.3, -0.2, 0.7};
  const synthetic::SyntheticCeiling ceiling;
  const auto seen = [&](const calib::CeilingView& camera) {
    registration::ImageMotion motion = registration::synthetic::MotionAt(camera, place);
    motion.scale = synthetic::kCeilingUnit / camera.MetresPerPixel();
    return ceiling.Render(camera.Size(), motion);
  };
  const cv::Mat drawn = view.Resample(seen(OtherView()), files.Maps()[1].map->Metadata());
  const cv::Mat expected = seen(calib::CeilingView::OfRectified(
      view.Metadata().view_size, view.Metadata().view_units_per_px, OtherView().T_base_view()));
  ASSERT_EQ(drawn.size(), expected.size());
  const double shifted = cv::norm(drawn.colRange(1, 240), expected.colRange(0, 239), cv::NORM_L1);
  const double right = cv::norm(drawn, expected, cv::NORM_L1);
  EXPECT_LT(right / static_cast<double>(drawn.total()), 1.5) << "grey levels";
  EXPECT_LT(4 * right, shifted);
}

TEST(CommonView, KeepsWhatHasNoContent) {
  MapFiles files;
  store::MapMetadata masked = MetadataOf(OtherView());
  masked.view_mask = cv::Mat(280, 300, CV_8UC1, cv::Scalar(255));
  masked.view_mask.colRange(0, 80).setTo(0);
  files.Add("a", MetadataOf(SmallView()), OneKeyframe());
  files.Add("b", masked, OneKeyframe());
  const CommonView view(files.Maps());
  // The left 80 of 300 px of 8 mm are 64 of 240 px of 10 mm.
  const cv::Mat& mask = view.Metadata().view_mask;
  ASSERT_EQ(mask.size(), cv::Size(240, 224));
  EXPECT_EQ(cv::countNonZero(mask.colRange(0, 64)), 0);
  EXPECT_EQ(cv::countNonZero(mask.colRange(68, 240)), 172 * 224);
  cv::Mat image(280, 300, CV_8UC1, cv::Scalar(200));
  image.setTo(0, masked.view_mask == 0);
  image.at<unsigned char>(100, 200) = 0;  // a black pixel is content
  const cv::Mat drawn = view.Resample(image, masked);
  EXPECT_EQ(cv::countNonZero(drawn == 0), cv::countNonZero(mask == 0));
  cv::Mat inside = drawn.colRange(68, 120);
  EXPECT_EQ(cv::countNonZero(inside != 200), 0) << "nothing of the blank part is smeared into it";
}

TEST(CommonView, HeightsAreDrawnToo) {
  MapFiles files;
  store::MapMetadata coarse = MetadataOf(OtherView());
  coarse.view_size = {150, 140};
  coarse.view_units_per_px *= 2;
  coarse.view_focal_px /= 2;
  files.Add("a", MetadataOf(OtherView()), OneKeyframe(true));
  files.Add("b", coarse, OneKeyframe());
  const CommonView view(files.Maps());
  const heights::HeightField drawn = view.Resample(
      *files.Maps()[0].map->ReadKeyframes().front().heights, files.Maps()[0].map->Metadata());
  EXPECT_EQ(drawn.first_px, Eigen::Vector2d(-25, 10));
  EXPECT_EQ(drawn.step_px, Eigen::Vector2d(50, 5));
  EXPECT_EQ(drawn.cells[1].rho, 1.2F) << "relative to a distance that is the same";
}

TEST(CommonView, HeightsNeedCamerasAtOneDistance) {
  MapFiles files;
  files.Add("a", MetadataOf(SmallView()), OneKeyframe());
  files.Add("b", MetadataOf(OtherView()), OneKeyframe(true));
  EXPECT_EQ(Refusal(files.Maps()),
            "a and b: their cameras are 2.2 and 1.6 m below the ceiling, which is not one "
            "plane; use maps of cameras at one height");
}

TEST(CommonView, MapsInPixelsMustBeOfOneGeometry) {
  MapFiles files;
  store::MapMetadata pixels = MetadataOf(SmallView());
  pixels.unit = "px";
  store::MapMetadata others = pixels;
  others.view_size = {160, 120};
  files.Add("a", MetadataOf(SmallView()), OneKeyframe());
  files.Add("b", pixels, OneKeyframe());
  files.Add("c", others, OneKeyframe());
  const std::vector<NamedMap>& maps = files.Maps();
  EXPECT_EQ(Refusal({maps[0], maps[1]}),
            "a and b: one map is in m, the other in px; make both with a rig");
  EXPECT_EQ(Refusal({maps[1], maps[2]}),
            "b and c: their images have 320x240 and 160x120 px; use maps of one kind of "
            "camera");
  EXPECT_EQ(Refusal({maps[1], maps[1]}), "none");
}

TEST(CommonView, CamerasThatDifferTooMuchAreRefused) {
  MapFiles files;
  store::MapMetadata coarse = MetadataOf(SmallView());
  coarse.view_units_per_px = 0.05;
  files.Add("a", MetadataOf(SmallView()), OneKeyframe());
  files.Add("b", coarse, OneKeyframe());
  EXPECT_THAT(Refusal(files.Maps()), testing::HasSubstr("has 64 x 48 px at the coarsest scale"));
}

}  // namespace
}  // namespace ceilmap::mapping
