#include "app/files/arguments.hpp"

#include <numbers>

#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

TEST(ParsePose2, TakesDegreesAndWraps) {
  const Pose2 pose = ParsePose2("-1.5,+2,450", "--origin");
  EXPECT_DOUBLE_EQ(pose.x, -1.5);
  EXPECT_DOUBLE_EQ(pose.y, 2);
  EXPECT_NEAR(pose.yaw, std::numbers::pi / 2, 1e-12);
}

TEST(ParsePose2, RefusesEverythingElse) {
  for (const std::string text : {"", "1", "1,2", "1,2,3,4", "1,2,", "a,2,3", "1,2,nan", "1,2,3m"}) {
    SCOPED_TRACE(text);
    support::ExpectInputError([&] { ParsePose2(text, "--origin"); }, {"--origin", "X,Y,YAW_DEG"});
  }
}

TEST(ParsePositiveNumbers, TakesAnyNumberOfThem) {
  EXPECT_THAT(ParsePositiveNumbers("0.5,2,10", "--segments"), testing::ElementsAre(0.5, 2, 10));
  EXPECT_THAT(ParsePositiveNumbers("3", "--segments"), testing::ElementsAre(3));
  for (const std::string text : {"", "1,", ",1", "0", "1,-2", "1,nan", "1;2", "one"}) {
    SCOPED_TRACE(text);
    support::ExpectInputError([&] { ParsePositiveNumbers(text, "--segments"); },
                              {"--segments", "> 0"});
  }
}

TEST(ParseNamedFile, TakesTheNameOrTheStem) {
  EXPECT_EQ(ParseNamedFile("run=a/b.tum").name, "run");
  EXPECT_EQ(ParseNamedFile("run=a/b.tum").file, "a/b.tum");
  EXPECT_EQ(ParseNamedFile("a/b.tum").name, "b");
  EXPECT_EQ(ParseNamedFile("a/x=1.tum").file, "a/x=1.tum");
}

TEST(ParseNamedFile, AFileOfTheWholeNameWins) {
  const support::TestFolder folder;
  const auto current = std::filesystem::current_path();
  folder.Write("x=1.tum", "");
  std::filesystem::current_path(folder.Path());
  const NamedFile file = ParseNamedFile("x=1.tum");
  std::filesystem::current_path(current);
  EXPECT_EQ(file.name, "x=1");
  EXPECT_EQ(file.file, "x=1.tum");
}

TEST(ParseSpread, MetresAndDegrees) {
  const PoseSpread spread = ParseSpread("0.5,18", "--start-spread");
  EXPECT_EQ(spread.position_m, 0.5);
  EXPECT_NEAR(spread.yaw_rad, std::numbers::pi / 10, 1e-12);
  for (const char* bad : {"", "1", "0,1", "1,-1", "1,2,3", "a,b", "nan,1"}) {
    EXPECT_THROW((void)ParseSpread(bad, "--start-spread"), InputError) << bad;
  }
}

}  // namespace
}  // namespace ceilmap::files
