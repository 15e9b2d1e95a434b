#include "localization/robot/ceiling_mapper.hpp"

#include "calib/base/error.hpp"
#include "localization/robot/ceiling_localizer.hpp"
#include "tests/localization/true_map.hpp"

namespace ceilmap::robot {
namespace {

using namespace localization::synthetic;

class CeilingMapperTest : public testing::Test {
 protected:
  CeilingMapperTest() {
    rig_.ceiling_height_m = kCeiling_m;
    rig_.up = UpCamera();
    rig_.robot = "tester";
  }

  /// An image every 10 cm along a straight line.
  Image ImageAt(int i) const {
    const calib::CeilingView view(*rig_.up, kCeiling_m);
    return {Seen(ceiling_, view, {0.1 * i, 0, 0}, static_cast<std::uint32_t>(i) + 1), 0.1 * i, i};
  }

  support::TempFolder folder_;
  std::filesystem::path file_ = folder_ / "drive.gpkg";
  SyntheticCeiling ceiling_{CeilingParams{}};
  calib::Rig rig_;
};

TEST_F(CeilingMapperTest, MapsADriveThatIsThenFoundOnTheMap) {
  constexpr int kFrames = 16;
  CeilingMapperParams params;
  params.provenance = "a test";
  CeilingMapper mapper(rig_, file_, params);
  for (int i = 0; i < kFrames; ++i) {
    const Estimate estimate = mapper.AddCeiling(ImageAt(i));
    ASSERT_TRUE(estimate.HasPose()) << i;
    EXPECT_EQ(estimate.index, i);
    EXPECT_NEAR(estimate.pose.pose.x, 0.1 * i, 0.01);
    EXPECT_GE(estimate.keyframe_id, 0);
  }
  EXPECT_EQ(mapper.PlacedFrames(), kFrames);
  EXPECT_FALSE(std::filesystem::exists(file_)) << "before Finish";
  int tiles = 0;
  const mapping::MappingResult result =
      mapper.Finish([&](int done, int /*total*/) { tiles = done; });
  EXPECT_GT(tiles, 0);
  EXPECT_EQ(result.report.tracked, kFrames);
  ASSERT_EQ(result.frames.size(), kFrames);
  EXPECT_NEAR(result.frames.back().T_map_base.x, 1.5, 0.01);

  CeilingLocalizer localizer(file_, rig_);
  EXPECT_EQ(localizer.Map().Metadata().unit, "m");
  EXPECT_EQ(localizer.Map().Metadata().robot, "tester");
  EXPECT_EQ(localizer.Map().Metadata().provenance, "a test");
  Estimate estimate;
  for (int i = 3; i < 12; ++i) estimate = localizer.AddCeiling(ImageAt(i));
  ASSERT_TRUE(estimate.HasPose());
  EXPECT_NEAR(estimate.pose.pose.x, 1.1, 0.01);
}

TEST_F(CeilingMapperTest, PipelinedImagesGiveTheSameMap) {
  CeilingMapper mapper(rig_, file_);
  std::vector<Estimate> estimates;
  for (int i = 0; i < 8; ++i) {
    if (const auto estimate = mapper.AddCeilingPipelined(ImageAt(i)))
      estimates.push_back(*estimate);
  }
  estimates.push_back(mapper.Flush().value());
  ASSERT_EQ(estimates.size(), 8U);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    EXPECT_EQ(estimates[i].index, static_cast<std::int64_t>(i));
    EXPECT_NEAR(estimates[i].pose.pose.x, 0.1 * static_cast<double>(i), 0.01);
  }
}

TEST_F(CeilingMapperTest, ExtendsAMap) {
  {
    CeilingMapper mapper(rig_, file_);
    for (int i = 0; i < 20; ++i) (void)mapper.AddCeiling(ImageAt(i));
    (void)mapper.Finish();
  }
  CeilingMapperParams params;
  params.append = mapping::HeldPoses::kFirstKeyframe;
  CeilingMapper mapper(rig_, file_, params);
  for (int i = 8; i < 24; ++i) (void)mapper.AddCeiling(ImageAt(i));
  const mapping::MappingResult result = mapper.Finish();
  ASSERT_EQ(result.frames.size(), 16U);
  EXPECT_NEAR(result.frames.back().T_map_base.x, 2.3, 0.02) << "in the frame of the first map";
}

TEST_F(CeilingMapperTest, WithoutARigLengthsAreInPixels) {
  CeilingMapper mapper(ImageAt(0).pixels.size(), file_);
  EXPECT_EQ(mapper.Metadata().unit, "px");
  Estimate estimate;
  for (int i = 0; i < 4; ++i) estimate = mapper.AddCeiling(ImageAt(i));
  EXPECT_NEAR(estimate.pose.pose.Translation().norm(), 30, 1) << "of 10 mm";
}

TEST_F(CeilingMapperTest, AMapperThatIsNotFinishedLeavesTheOldMap) {
  {
    CeilingMapper mapper(rig_, file_);
    (void)mapper.AddCeiling(ImageAt(0));
    (void)mapper.Finish();
  }
  const auto size = std::filesystem::file_size(file_);
  {
    CeilingMapper mapper(rig_, file_);
    for (int i = 0; i < 12; ++i) (void)mapper.AddCeiling(ImageAt(i));
  }
  EXPECT_EQ(std::filesystem::file_size(file_), size);
}

TEST_F(CeilingMapperTest, BadInputIsRefused) {
  EXPECT_THROW(CeilingMapper(calib::Rig{}, file_), InputError);
  EXPECT_THROW(CeilingMapper(rig_, folder_ / "none" / "map.gpkg"), InputError);
  CeilingMapperParams params;
  params.append = mapping::HeldPoses::kFirstKeyframe;
  EXPECT_THROW(CeilingMapper(rig_, file_, params), InputError) << "nothing to extend";
  CeilingMapper mapper(rig_, file_);
  EXPECT_THROW(mapper.AddCeiling({cv::Mat(100, 100, CV_8UC1), 1, 0}), InputError);
  EXPECT_THROW(mapper.Finish(), RunError) << "no frame";
}

}  // namespace
}  // namespace ceilmap::robot
