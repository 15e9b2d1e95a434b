// A few of the faults that tests/reliability.sh covers: no accepted wrong pose, no map
// lost, no crash.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/faults/lab.hpp"
#include "tests/faults/system_faults.hpp"
#include "tests/faults/video_runs.hpp"
#include "tests/support/encoded_video.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::faults {
namespace {

using testing::HasSubstr;

class Faults : public testing::Test {
 protected:
  /// One for all tests: its map takes a while.
  static const Lab& TheLab() {
    static const support::TestFolder kFolder;
    static const Lab kLab(kFolder.Path());
    return kLab;
  }
};

void ExpectSurvived(const Outcome& outcome) {
  EXPECT_TRUE(outcome.orderly) << outcome.exit_code << ": " << outcome.message;
  EXPECT_EQ(outcome.wrong, 0) << "largest error " << outcome.largest_m << " m";
  EXPECT_NE(outcome.map, MapState::kLost);
}

// The images of a copied recording share their pixels with the good one.
TEST(RecordingFaults, LeaveTheGoodRecordingAsItIs) {
  constexpr int kShots = 12;
  Recording good;
  std::vector<cv::Mat> before;
  for (int i = 0; i < kShots; ++i) {
    cv::Mat image(24, 32, CV_8UC1);
    cv::randu(image, 20, 200);
    before.push_back(image.clone());
    good.push_back({image, 0.1 * i, {}});
  }
  for (const FaultGroup& group : AllGroups()) {
    for (const Fault& fault : group.faults) {
      if (!fault.recording) continue;
      Random random(1);
      (void)fault.recording(good, random);
      for (std::size_t i = 0; i < good.size(); ++i) {
        ASSERT_EQ(cv::norm(good[i].image, before[i], cv::NORM_INF), 0) << fault.name << ", " << i;
      }
    }
  }
}

TEST_F(Faults, MissingFramesCostNothing) {
  const Outcome outcome = TheLab().Map(FaultNamed("dropped frames, 50 %"), 1);
  ExpectSurvived(outcome);
  EXPECT_EQ(outcome.map, MapState::kNew);
  EXPECT_GT(outcome.Coverage(), 0.95);
  EXPECT_LT(outcome.rmse_m, 0.005);
}

TEST_F(Faults, DamagedPacketsGiveNoPosesFromBefore) {
  const Fault& fault = FaultNamed("H.264 (MP4), bytes flipped in 5 % of packets");
  const Outcome localized = TheLab().Localize(fault, 1);
  ExpectSurvived(localized);
  EXPECT_GT(localized.placed, 0);
}

// The drive continues elsewhere under the same tiles.
TEST_F(Faults, DarknessDuringTheDriveCausesNoWrongPose) {
  const Outcome outcome = TheLab().Map(FaultNamed("dark for a third of the way"), 1);
  ExpectSurvived(outcome);
  EXPECT_GT(outcome.Coverage(), 0.3);
}

TEST_F(Faults, WhiteImagesSayNothing) {
  ExpectSurvived(TheLab().Map(FaultNamed("exposure jumps, 10 of 0.35 to 2.5"), 1));
}

TEST_F(Faults, BlurredImagesHaveALargeCovariance) {
  ExpectSurvived(TheLab().Map(FaultNamed("motion blur of 25 px in 20 %"), 1));
}

// In the turns the codec repeats parts of the images, which looks like depth, tilt and slow turns.
TEST_F(Faults, AVideoThatIsCompressedTooMuchGivesNoWrongPose) {
  const support::TestFolder folder;
  const World world = TilesWorld();
  std::vector<cv::Mat> images;
  for (const Shot& shot : world.shots) images.push_back(shot.image);
  support::WriteEncoded(
      folder.Path() / "up.mp4",
      {.codec = "libx265", .options = {{"crf", "40"}, {"x265-params", "log-level=error"}}},
      images);
  const Outcome outcome = MapStoredVideo(world, "up.mp4", false, folder.Path());
  ExpectSurvived(outcome);
  EXPECT_GT(outcome.Coverage(), 0.2);
  EXPECT_LT(outcome.largest_m, 0.02);
}

TEST_F(Faults, ASizeThatChangesIsRefused) {
  const Outcome outcome = TheLab().Map(FaultNamed("frame size that changes midway"), 1);
  ExpectSurvived(outcome);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.map, MapState::kOld);
  EXPECT_THAT(outcome.message, HasSubstr("is 160x120 px, the frames before it are 320x240"));
}

TEST_F(Faults, ABagThatIsCutOffIsMappedUpToThere) {
  const Outcome outcome = TheLab().Map(FaultNamed("MCAP cut off at two thirds", "bags"), 1);
  ExpectSurvived(outcome);
  EXPECT_EQ(outcome.map, MapState::kNew);
  EXPECT_GT(outcome.Coverage(), 0.6);
}

// With times by the log, up to half a second late, poses would be those of other moments.
TEST_F(Faults, ImagesThatAreRecordedLateGetNoOtherTimes) {
  const Outcome outcome =
      TheLab().Localize(FaultNamed("20 % of messages recorded up to 0.5 s late", "bags"), 1);
  ExpectSurvived(outcome);
  EXPECT_GT(outcome.Coverage(), 0.7);
}

// The parts on both sides of the dark are connected by nothing else.
TEST(FaultsOfWheels, AGyroOfTheOppositeSignMovesNoPartOfTheMap) {
  const support::TestFolder folder;
  const FaultGroup& group = GroupNamed("odometry");
  const Lab lab(folder.Path(), group.world());
  const Outcome outcome =
      lab.Map(FaultNamed("dark, and a gyro of the opposite sign", group.name), 1);
  ExpectSurvived(outcome);
  EXPECT_GT(outcome.Coverage(), 0.3);
}

void ExpectSurvived(const SystemResult& result) {
  EXPECT_GT(result.trials, 0);
  EXPECT_EQ(result.lost_maps, 0);
  EXPECT_EQ(result.disorderly, 0) << result.message;
}

TEST_F(Faults, AFullDiskLeavesTheOldMap) {
  ExpectSurvived(DiskFull(TheLab(), 4, 1));
}

TEST_F(Faults, AKilledRunLeavesTheOldMapOrTheNewOne) {
  const SystemResult result = KilledAtAWrite(TheLab(), 6, 1);
  ExpectSurvived(result);
  EXPECT_GT(result.old_maps, 0);
}

TEST_F(Faults, AReadOnlyFolderIsReportedAtOnce) {
  const SystemResult result = ReadOnlyFolder(TheLab());
  ExpectSurvived(result);
  EXPECT_THAT(result.message, HasSubstr("cannot write in folder"));
}

TEST_F(Faults, TheSecondWriterOfAMapIsRefused) {
  const SystemResult result = TwoWriters(TheLab());
  ExpectSurvived(result);
  EXPECT_THAT(result.message, HasSubstr("another run is writing it"));
  EXPECT_EQ(result.new_maps, 1);
}

TEST_F(Faults, AMapMayBeReplacedWhileItIsRead) {
  ExpectSurvived(ReplacedWhileRead(TheLab()));
}

}  // namespace
}  // namespace ceilmap::faults
