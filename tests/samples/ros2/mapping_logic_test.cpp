#include "ceilmap_ros/logic/mapping_logic.hpp"

#include <gmock/gmock.h>

#include "calib/base/error.hpp"
#include "tests/samples/ros2/lab_drive.hpp"
#include "tests/support/temp_folder.hpp"

namespace ceilmap_ros {
namespace {

class MappingLogicTest : public testing::Test {
 protected:
  MappingLogicTest() { params_.map = folder_ / "lab.gpkg"; }

  std::optional<Fix> Next(int i, MappingLogic& logic) const {
    drive_.Send(i, logic.Sensors());
    return logic.Step(LabDrive::StampOf(i));
  }
  static SaveResult Save(MappingLogic& logic, const std::filesystem::path& copy = {}) {
    SaveResult saved{false, "not done"};
    logic.RequestSave(copy, [&](const SaveResult& result) { saved = result; });
    EXPECT_EQ(logic.Step(0), std::nullopt);
    return saved;
  }

  ceilmap::support::TempFolder folder_;
  MappingOptions params_;
  LabDrive drive_{24};
};

TEST_F(MappingLogicTest, MapsAndSaves) {
  params_.mapper.mapping.origin = {1, 2, 0.5};
  MappingLogic logic(LabDrive::Rig(), params_);
  EXPECT_EQ(logic.Preview().width, 0U);
  EXPECT_EQ(Save(logic).message, "no image was mapped yet; drive first");
  for (int i = 0; i < 20; ++i) {
    const auto fix = Next(i, logic);
    ASSERT_TRUE(fix && fix->pose && fix->map_to_odom) << i;
    const Pose2 truth = Pose2{1, 2, 0.5} * drive_.T_map_base(i);
    EXPECT_LT(Distance(fix->pose->pose, truth), 0.02) << i;
    EXPECT_LT(Distance(fix->map_to_odom->T_map_odom * drive_.T_odom_base(i), truth), 0.02) << i;
  }
  EXPECT_EQ(logic.Diagnose(LabDrive::StampOf(20)).message, "tracking");
  const CeilingGrid preview = logic.Preview();
  EXPECT_GT(preview.width * preview.height, 1000U);
  EXPECT_FALSE(std::filesystem::exists(params_.map));

  const SaveResult saved = Save(logic, folder_ / "copy.gpkg");
  const std::string ended = params_.map.string() + ": 20 images; mapping has ended";
  EXPECT_EQ(saved.message, ended + "; copied to " + (folder_ / "copy.gpkg").string());
  EXPECT_TRUE(saved.success);
  EXPECT_EQ(ceilmap::store::MapReader(folder_ / "copy.gpkg").ReadTrajectory().size(), 20U);
  EXPECT_GT(logic.Preview().width, 0U);
  EXPECT_EQ(Next(20, logic), std::nullopt);
  EXPECT_EQ(logic.Diagnose(LabDrive::StampOf(20)).message, ended);
  EXPECT_EQ(Save(logic).message, ended) << "once more";
  const SaveResult refused = Save(logic, folder_ / "none" / "copy.gpkg");
  EXPECT_FALSE(refused.success);
  EXPECT_THAT(refused.message, testing::StartsWith(ended + "; the copy failed: "));
}

TEST_F(MappingLogicTest, AMapThatGrowsAgainHasNoPosesUntilItIsSaved) {
  {
    MappingLogic logic(LabDrive::Rig(), params_);
    for (int i = 0; i < 15; ++i) (void)Next(i, logic);
    ASSERT_TRUE(Save(logic).success);
  }
  params_.mapper.append = ceilmap::mapping::HeldPoses::kFirstKeyframe;
  MappingLogic logic(LabDrive::Rig(), params_);
  for (int i = 8; i < 24; ++i) {
    const auto fix = Next(i, logic);
    ASSERT_TRUE(fix);
    EXPECT_TRUE(fix->estimate.HasPose());
    EXPECT_FALSE(fix->pose);
    EXPECT_FALSE(fix->map_to_odom);
  }
  const SaveResult saved = Save(logic);
  EXPECT_TRUE(saved.success) << saved.message;
  EXPECT_EQ(ceilmap::store::MapReader(params_.map).ReadTrajectory().size(), 31U);
}

TEST_F(MappingLogicTest, AClockThatBeginsAgainDoesNotEndTheMap) {
  MappingLogic logic(LabDrive::Rig(), params_);
  for (int i = 0; i < 12; ++i) (void)Next(i, logic);
  std::optional<Fix> fix;
  for (int i = 0; i < 12; ++i) fix = Next(i, logic);
  ASSERT_TRUE(fix);
  EXPECT_EQ(logic.Sensors().Counts().clock_resets, 1);
  EXPECT_EQ(logic.Diagnose(LabDrive::StampOf(12)).level == Health::Level::kError, false);
}

TEST_F(MappingLogicTest, ImagesOfAnotherSize) {
  MappingLogic logic(LabDrive::Rig(), params_);
  const auto next = [&](int i, cv::Size size) {
    cv::Mat image;
    cv::resize(drive_.Image(i), image, size, 0, 0, cv::INTER_AREA);
    logic.Sensors().AddCeiling(image, LabDrive::StampOf(i), LabDrive::StampOf(i));
    return logic.Step(LabDrive::StampOf(i));
  };
  ASSERT_TRUE(next(0, {320, 240}));
  ASSERT_TRUE(next(1, {320, 240}));
  EXPECT_EQ(next(2, {640, 480}), std::nullopt);
  EXPECT_EQ(logic.Diagnose(LabDrive::StampOf(2)).message,
            "the camera changed while the map grew; save the map and restart");
  EXPECT_TRUE(next(3, {320, 240}));
}

TEST_F(MappingLogicTest, BadParametersAreRefused) {
  params_.mosaic_max_px = 100;
  EXPECT_THROW(MappingLogic(LabDrive::Rig(), params_), ceilmap::InputError);
  params_.mosaic_max_px = 1000;
  params_.map = folder_ / "none" / "lab.gpkg";
  EXPECT_THROW(MappingLogic(LabDrive::Rig(), params_), ceilmap::InputError);
}

}  // namespace
}  // namespace ceilmap_ros
