// Several recordings in one map.

#include <cmath>

#include "app/files/tum.hpp"
#include "tests/integration/sites.hpp"

namespace ceilmap::integration {
namespace {

using support::ReadAll;
using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

/// Both drives are one straight line: frame i of the first room lies i steps from the start.
void ExpectOnTheLine(const std::vector<StampedPose>& poses) {
  ASSERT_FALSE(poses.empty());
  for (const StampedPose& pose : poses) {
    const double frame = pose.stamp_s < 500 ? (pose.stamp_s - 100) * 10
                                            : (pose.stamp_s - 1000) * 10 + Sites::kSecondBegins;
    EXPECT_NEAR(pose.position.x(), -kStep.y * frame * 0.01, 0.003) << pose.stamp_s;
    EXPECT_NEAR(pose.position.y(), kStep.x * frame * 0.01, 0.003) << pose.stamp_s;
    EXPECT_NEAR(YawOf(pose), 0, 0.003) << pose.stamp_s;
  }
}

TEST(Sites, AppendPutsASecondRecordingIntoTheMap) {
  const Sites sites;
  ASSERT_EQ(sites.Map("first", "m.gpkg").exit_code, 0);
  std::vector<std::string> append = sites.MapArguments("second", "m.gpkg");
  append.emplace_back("--append");
  const support::ProcessResult result = sites.recordings.Run(append);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  // The trajectory is that of the new recording, in the map's frame.
  const std::vector<StampedPose> poses = files::ReadTum(sites.recordings.out / "second.tum");
  EXPECT_EQ(poses.size(), static_cast<std::size_t>(Sites::kSecond));
  ExpectOnTheLine(poses);
  const nlohmann::json info = sites.Info("m.gpkg");
  EXPECT_EQ(info["trajectory_poses"], Sites::kFirst + Sites::kSecond);
  EXPECT_GT(info["quality"]["loops"]["accepted"], 0);
  EXPECT_THAT(info["provenance"].get<std::string>(), HasSubstr("--append"));
}

TEST(Sites, MergeMakesOneMapOfTwo) {
  const Sites sites;
  ASSERT_EQ(sites.Map("first", "a.gpkg").exit_code, 0);
  ASSERT_EQ(sites.Map("second", "b.gpkg").exit_code, 0);
  const support::ProcessResult result =
      sites.recordings.Run({"merge", "a.gpkg", "b.gpkg", "-o", "s.gpkg"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("images agree"));
  EXPECT_EQ(sites.Info("s.gpkg")["trajectory_poses"], Sites::kFirst + Sites::kSecond);
  const support::ProcessResult exported =
      sites.recordings.Run({"export", "s.gpkg", "--format", "tum", "-o", "s.tum"});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const std::vector<StampedPose> poses = files::ReadTum(sites.recordings.out / "s.tum");
  EXPECT_EQ(poses.size(), static_cast<std::size_t>(Sites::kFirst + Sites::kSecond));
  ExpectOnTheLine(poses);
}

TEST(Sites, OtherRoomsAreRefusedWithTheReason) {
  const Sites sites;
  ASSERT_EQ(sites.Map("first", "a.gpkg").exit_code, 0);
  ASSERT_EQ(sites.Map("elsewhere", "b.gpkg").exit_code, 0);
  const support::ProcessResult merge =
      sites.recordings.Run({"merge", "a.gpkg", "b.gpkg", "-o", "s.gpkg"});
  EXPECT_EQ(merge.exit_code, 1);
  EXPECT_THAT(merge.err, HasSubstr("b.gpkg cannot be joined with a.gpkg: "));
  EXPECT_THAT(sites.recordings.out.Names(), Not(Contains(HasSubstr("s.gpkg"))));

  const std::string before = ReadAll(sites.recordings.out / "a.gpkg");
  std::vector<std::string> arguments = sites.MapArguments("elsewhere", "a.gpkg");
  arguments.emplace_back("--append");
  const support::ProcessResult append = sites.recordings.Run(arguments);
  EXPECT_EQ(append.exit_code, 1);
  EXPECT_THAT(append.err, HasSubstr("the map is not changed"));
  EXPECT_TRUE(ReadAll(sites.recordings.out / "a.gpkg") == before);
  EXPECT_THAT(sites.recordings.out.Names(), Not(Contains(EndsWith(".partial"))));
}

TEST(Sites, WhatDoesNotFitIsRefusedBeforeAnyWork) {
  const Sites sites;
  const Recordings& test = sites.recordings;
  ASSERT_EQ(sites.Map("first", "a.gpkg").exit_code, 0);
  ASSERT_EQ(test.Run({"map", "--up=@second", "-o", "pixels.gpkg"}).exit_code, 0);
  const auto refused = [&test](const std::vector<std::string>& arguments, const char* why) {
    const support::ProcessResult result = test.Run(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_THAT(result.err, HasSubstr(why));
  };
  refused({"merge", "a.gpkg", "pixels.gpkg", "-o", "s.gpkg"}, "pixels.gpkg");
  refused({"merge", "a.gpkg", "-o", "s.gpkg"}, "at least two");
  refused({"merge", "a.gpkg", "none.gpkg", "-o", "s.gpkg"}, "none.gpkg");
  refused({"map", "--up=@second", "--append", "-o", "none.gpkg"}, "none.gpkg");
  refused({"map", "--up=@second", "--append", "-o", "a.gpkg"}, "--append: a.gpkg");
}

}  // namespace
}  // namespace ceilmap::integration
