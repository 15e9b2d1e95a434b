#include "app/reports/coverage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ceilmap::reports {
namespace {

Coverage OnMap(std::int64_t on_map, std::int64_t frames) {
  Coverage coverage;
  coverage.frames = frames;
  coverage.on_map = on_map;
  coverage.lost = frames - on_map;
  return coverage;
}

TEST(Coverage, ComesFromTheReportOfAMap) {
  mapping::MapperReport report;
  report.frames = 100;
  report.tracked = 60;
  report.unconnected = 20;
  report.lost = 30;
  report.without_texture = 12;
  report.ambiguous = 10;
  SensorResult sensors;
  sensors.report.heading.emplace();
  const Coverage coverage = CoverageOf(report, recordings::StampOrigin::kContainer, sensors);
  EXPECT_EQ(coverage.frames, 100);
  EXPECT_EQ(coverage.on_map, 40);
  EXPECT_EQ(coverage.unconnected, 20);
  EXPECT_EQ(coverage.lost, 18);
  EXPECT_EQ(coverage.without_texture, 12);
  EXPECT_EQ(coverage.ambiguous, 10);
  EXPECT_FALSE(coverage.localizes);
  EXPECT_FALSE(coverage.has_stamps);
  EXPECT_TRUE(coverage.has_heading);
  EXPECT_TRUE(CoverageOf(report, recordings::StampOrigin::kClock, {}).has_stamps);
}

TEST(Coverage, ComesFromTheReportOfALocalization) {
  localization::LocalizerReport report;
  report.frames = 100;
  report.tracking = 60;
  report.relocalized = 3;
  report.lost = 30;
  report.ambiguous = 7;
  const Coverage coverage = CoverageOf(report, recordings::StampOrigin::kStampsFile, {});
  EXPECT_EQ(coverage.on_map, 63);
  EXPECT_EQ(coverage.lost, 30);
  EXPECT_EQ(coverage.ambiguous, 7);
  EXPECT_TRUE(coverage.localizes);
  EXPECT_TRUE(coverage.has_stamps);
}

TEST(Coverage, IsPrintedAsNumberAndPercentage) {
  EXPECT_EQ(ToString(OnMap(4, 145)), "4 of 145 frames (3 %)");
  EXPECT_EQ(ToString(OnMap(229, 230)), "229 of 230 frames (99 %)");
  EXPECT_EQ(ToString(OnMap(999, 1000)), "999 of 1000 frames (99 %)") << "100 % are all of them";
  EXPECT_EQ(ToString(OnMap(1, 1000)), "1 of 1000 frames (1 %)") << "0 % are none of them";
  EXPECT_EQ(ToString(OnMap(0, 5)), "0 of 5 frames (0 %)");
  EXPECT_EQ(ToString(OnMap(1, 1)), "1 of 1 frame (100 %)");
  EXPECT_EQ(ToString(OnMap(0, 0)), "0 of 0 frames (0 %)");
}

TEST(Coverage, IsPartOfTheSummary) {
  nlohmann::ordered_json quality;
  Summarize(OnMap(4, 16), quality);
  EXPECT_EQ(quality.dump(), R"({"on_map":4,"on_map_ratio":0.25})");
}

TEST(Coverage, HalfOfTheFramesIsEnough) {
  EXPECT_EQ(CoverageWarning(OnMap(50, 100)), std::nullopt);
  EXPECT_NE(CoverageWarning(OnMap(49, 100)), std::nullopt);
  EXPECT_NE(CoverageWarning(OnMap(10, 100)), std::nullopt);
  EXPECT_EQ(CoverageWarning(OnMap(9, 100)), std::nullopt) << "it is a failure";
}

TEST(Coverage, LessThanATenthIsAFailure) {
  EXPECT_EQ(CoverageFailure(OnMap(10, 100), "up.mp4"), "");
  EXPECT_EQ(CoverageFailure(OnMap(1, 10), "up.mp4"), "");
  EXPECT_EQ(CoverageFailure(OnMap(1, 1), "up.mp4"), "");
  EXPECT_EQ(CoverageFailure(OnMap(0, 0), "up.mp4"), "");
  EXPECT_EQ(CoverageFailure(OnMap(9, 100), "up.mp4"),
            "up.mp4: only 9 of 100 frames (9 %) are on the map: " + LikelyCause(OnMap(9, 100)));
  EXPECT_EQ(CoverageFailure(OnMap(0, 5), "up.mp4"),
            "up.mp4: none of its 5 frames is on the map: " + LikelyCause(OnMap(0, 5)));
}

TEST(Coverage, NamesTheLargestGroupAsTheCause) {
  Coverage coverage = OnMap(20, 100);
  EXPECT_EQ(LikelyCause(coverage),
            "80 could not be connected to the frames before them; record more frames a second or "
            "drive more slowly, compress less, and check that the rig is that of this camera");
  coverage.has_stamps = false;
  EXPECT_EQ(CoverageWarning(coverage),
            "only 20 of 100 frames (20 %) are on the map: 80 could not be connected to the frames "
            "before them; if frames are missing, give --stamps; record more frames a second or "
            "drive more slowly, compress less, and check that the rig is that of this camera");
  coverage.lost = 20;
  coverage.without_texture = 60;
  EXPECT_EQ(LikelyCause(coverage),
            "60 show no texture: dark, uniform, covered or out of focus; light the room, focus on "
            "the ceiling, and look at the images");
  coverage.without_texture = 0;
  coverage.unconnected = 60;
  EXPECT_EQ(LikelyCause(coverage),
            "60 are in parts that are not connected to the map; drive back over the start, or "
            "where the ceilings overlap, or map each part separately");
}

TEST(Coverage, AdvisesWhatIsNotGivenYetUnderAPeriodicCeiling) {
  Coverage coverage = OnMap(20, 100);
  coverage.lost = 10;
  coverage.ambiguous = 70;
  EXPECT_EQ(LikelyCause(coverage),
            "70 fit several places, because the ceiling is periodic; give --omni or --heading, or "
            "drive where the ceiling is unique: past lamps, beams, signs or marks");
  coverage.has_heading = true;
  EXPECT_EQ(LikelyCause(coverage),
            "70 fit several places, because the ceiling is periodic; drive where the ceiling is "
            "unique: past lamps, beams, signs or marks");
  coverage.localizes = true;
  EXPECT_EQ(LikelyCause(coverage),
            "70 fit several places, because the ceiling is periodic; give --start, or drive "
            "farther, to where the ceiling is unique");
  coverage.has_start = true;
  EXPECT_EQ(LikelyCause(coverage),
            "70 fit several places, because the ceiling is periodic; drive farther, to where the "
            "ceiling is unique");
}

TEST(Coverage, ALostRobotMayBeOnAnotherMap) {
  Coverage coverage = OnMap(20, 100);
  coverage.localizes = true;
  EXPECT_EQ(LikelyCause(coverage),
            "80 match no place of the map; is it the map of this place, and the rig of this "
            "robot? Outside the mapped area, extend the map by 'ceilmap map --append'");
}

}  // namespace
}  // namespace ceilmap::reports
