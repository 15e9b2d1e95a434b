#include "app/recordings/simulation_folder.hpp"

#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

TEST(WithSeed, LeavesATextThatHasTheSeed) {
  EXPECT_EQ(WithSeed("# a\nseed: 4  # b\n", "s.yaml", 4), "# a\nseed: 4  # b\n");
}

TEST(WithSeed, ReplacesTheSeedAndKeepsTheRest) {
  EXPECT_EQ(WithSeed("# a\nseed: 4  # b\nrobot: r\n", "s.yaml", 17),
            "# a\nseed: 17  # b\nrobot: r\n");
  EXPECT_EQ(WithSeed("seed: 123", "s.yaml", 17), "seed: 17");
  EXPECT_EQ(WithSeed("seed: 123\r\nrobot: r\r\n", "s.yaml", 17), "seed: 17\r\nrobot: r\r\n");
}

TEST(WithSeed, AddsASeed) {
  EXPECT_EQ(WithSeed("robot: r\n", "s.yaml", 17), "seed: 17\nrobot: r\n");
}

TEST(WithSeed, SaysItWhereTheStyleIsAnother) {
  EXPECT_EQ(WithSeed("{seed: 3, robot: r}\n", "s.yaml", 17),
            "# rendered with --seed 17\n{seed: 3, robot: r}\n");
}

TEST(SimulationFolder, LeavesNothingWithoutCommit) {
  const support::TestFolder test;
  {
    const SimulationFolder folder(test / "new", RecordingFormat::kVideo, files::Existing::kRefuse);
  }
  EXPECT_THAT(test.Names(), testing::IsEmpty());
}

TEST(SimulationFolder, RefusesWhatItMustNotReplace) {
  const support::TestFolder test;
  const auto open = [&test](files::Existing existing) {
    const SimulationFolder folder(test.Path(), RecordingFormat::kImages, existing);
  };
  test.Write("notes.txt", "of somebody");
  EXPECT_NO_THROW(open(files::Existing::kRefuse));
  test.Write("truth.tum", "of an earlier run");
  support::ExpectInputError(
      [&] { open(files::Existing::kRefuse); },
      {"holds truth.tum already; give --force to replace it, or another name"});
  EXPECT_NO_THROW(open(files::Existing::kReplace));
  std::filesystem::create_directory(test / "up");
  test.Write("up/000000.png", "of an earlier run");
  EXPECT_NO_THROW(open(files::Existing::kReplace));
  test.Write("up/holiday.png", "of somebody");
  support::ExpectInputError([&] { open(files::Existing::kReplace); }, {"up", "other things"});
  std::filesystem::remove_all(test / "up");
  std::filesystem::create_directory(test / "forward");
  test.Write("forward/holiday.png", "of somebody");
  support::ExpectInputError([&] { open(files::Existing::kReplace); }, {"forward", "other things"});
  std::filesystem::remove_all(test / "forward");
  std::filesystem::remove(test / "truth.tum");
  test.Write("forward.mkv", "of an earlier run");
  support::ExpectInputError([&] { open(files::Existing::kRefuse); }, {"forward.mkv", "--force"});
  support::ExpectInputError(
      [&] {
        const SimulationFolder folder(
            test / "notes.txt", RecordingFormat::kVideo, files::Existing::kReplace);
      },
      {"notes.txt", "not a folder"});
  support::ExpectInputError(
      [&] {
        const SimulationFolder folder(
            test / "none/new", RecordingFormat::kVideo, files::Existing::kRefuse);
      },
      {"none", "does not exist"});
}

}  // namespace
}  // namespace ceilmap::recordings
