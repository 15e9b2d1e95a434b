#include "app/recordings/simulation_folder.hpp"

#include <cstdint>
#include <optional>

#include "tests/support/test_folder.hpp"

namespace ceilmap::recordings {
namespace {

/// The text of a scene that was rendered with another seed, or in another session.
std::string Rendered(const std::string& text,
                     std::optional<std::uint64_t> seed,
                     std::optional<int> session = {}) {
  return TextOf(text, "s.yaml", simulator::ParseScene(text, "s.yaml", {seed, session}));
}

TEST(TextOf, LeavesATextThatHasTheSeed) {
  EXPECT_EQ(Rendered("# a\nseed: 4  # b\n", 4), "# a\nseed: 4  # b\n");
}

TEST(TextOf, ReplacesTheSeedAndKeepsTheRest) {
  EXPECT_EQ(Rendered("# a\nseed: 4  # b\nrobot: r\n", 17), "# a\nseed: 17  # b\nrobot: r\n");
  EXPECT_EQ(Rendered("seed: 123", 17), "seed: 17");
  EXPECT_EQ(Rendered("seed: 123\r\nrobot: r\r\n", 17), "seed: 17\r\nrobot: r\r\n");
}

TEST(TextOf, AddsASeed) {
  EXPECT_EQ(Rendered("robot: r\n", 17), "seed: 17\nrobot: r\n");
}

TEST(TextOf, SaysItWhereTheStyleIsAnother) {
  EXPECT_EQ(Rendered("{seed: 3, robot: r}\n", 17),
            "# rendered with --seed 17\n{seed: 3, robot: r}\n");
}

TEST(TextOf, ReplacesTheSession) {
  EXPECT_EQ(Rendered("session: 0\nsessions: {}\n", {}, 7), "session: 7\nsessions: {}\n");
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
