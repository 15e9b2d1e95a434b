#include "app/files/output_files.hpp"

#include <sys/stat.h>

#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(CheckOutputFiles, LeavesNothingBehind) {
  const support::TestFolder folder;
  CheckOutputFiles({folder / "a.tum", "", folder / "b.tum"}, Existing::kRefuse);
  EXPECT_THAT(folder.Names(), IsEmpty());
}

TEST(CheckOutputFiles, KeepsWhatIsThere) {
  const support::TestFolder folder;
  const auto file = folder.Write("a.tum", "old");
  CheckOutputFiles({file}, Existing::kReplace);
  EXPECT_EQ(support::ReadAll(file), "old");
}

TEST(CheckOutputFiles, RefusesWhatExists) {
  const support::TestFolder folder;
  const auto file = folder.Write("a.tum", "old");
  support::ExpectInputError(
      [&] {
        CheckOutputFiles({folder / "b.tum", file}, Existing::kRefuse);
      },
      {file.string() + ": exists already; give --force to replace it, or another name"});
  CheckOutputFiles({folder / "b.tum", file}, Existing::kRefuse, file);
  EXPECT_THAT(folder.Names(), ElementsAre("a.tum"));
}

TEST(CheckOutputFolder, TakesANewOneAndAnEmptyOne) {
  const support::TestFolder folder;
  CheckOutputFolder(folder.Path(), Existing::kRefuse);
  CheckOutputFolder(folder / "new", Existing::kRefuse);
  CheckOutputFolder(folder / "new/", Existing::kRefuse);
  EXPECT_THAT(folder.Names(), IsEmpty());
}

TEST(CheckOutputFolder, RefusesOneWithFiles) {
  const support::TestFolder folder;
  folder.Write("notes.txt", "of somebody");
  support::ExpectInputError(
      [&] { CheckOutputFolder(folder.Path(), Existing::kRefuse); },
      {folder.Path().string() + ": holds files already; give --force to replace those of the same "
                                "names, or name a new folder"});
  CheckOutputFolder(folder.Path(), Existing::kReplace);
  EXPECT_THAT(folder.Names(), ElementsAre("notes.txt"));
}

TEST(CheckOutputFolder, RefusesWhatCannotBeAFolder) {
  const support::TestFolder folder;
  folder.Write("file", "");
  support::ExpectInputError([&] { CheckOutputFolder(folder / "file", Existing::kReplace); },
                            {"file: is a file, must be a folder; give another name"});
  support::ExpectInputError([&] { CheckOutputFolder(folder / "none/new", Existing::kReplace); },
                            {"none", "does not exist"});
}

TEST(CheckOutputFiles, RefusesWhatCannotBeWritten) {
  const support::TestFolder folder;
  support::ExpectInputError([&] { CheckOutputFiles({folder / "none/a.tum"}, Existing::kRefuse); },
                            {"none", "does not exist"});
  // Not even root can make a file there.
  support::ExpectInputError([&] { CheckOutputFiles({"/proc/a.tum"}, Existing::kRefuse); },
                            {"/proc", "cannot write"});
  support::ExpectInputError([&] { CheckOutputFiles({folder.Path()}, Existing::kRefuse); },
                            {"is a folder"});
}

TEST(CheckOutputFiles, RefusesPipesAndDevices) {
  const support::TestFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  support::ExpectInputError([&] { CheckOutputFiles({folder / "pipe"}, Existing::kRefuse); },
                            {"pipe", "would be replaced"});
}

TEST(CheckOutputFiles, RefusesOneFileForTwoResults) {
  const support::TestFolder folder;
  support::ExpectInputError(
      [&] {
        CheckOutputFiles({folder / "a.tum", folder / "./a.tum"}, Existing::kRefuse);
      },
      {"two results"});
}

TEST(WriteFileAtomically, ReplacesTheOldFile) {
  const support::TestFolder folder;
  const auto file = folder.Write("a.json", "old and longer");
  WriteFileAtomically(file, "new");
  EXPECT_EQ(support::ReadAll(file), "new");
  EXPECT_THAT(folder.Names(), ElementsAre("a.json"));
}

TEST(WriteText, WithoutCommitTheOldFileStays) {
  const support::TestFolder folder;
  const auto file = folder.Write("a.json", "old");
  {
    const AtomicFile aside(file);
    WriteText(aside, "new");
    EXPECT_EQ(support::ReadAll(file), "old");
  }
  EXPECT_EQ(support::ReadAll(file), "old");
  EXPECT_THAT(folder.Names(), ElementsAre("a.json"));
}

TEST(WriteText, ASecondWriterOfAFileIsRefused) {
  const support::TestFolder folder;
  {
    const AtomicFile first(folder / "a.json");
    support::ExpectInputError([&] { const AtomicFile second(folder / "a.json"); },
                              {"a.json: another run is writing it"});
    WriteText(first, "new");
  }
  EXPECT_TRUE(folder.Names().empty());
  WriteFileAtomically(folder / "a.json", "newer");  // the lock went with the first
  EXPECT_THAT(folder.Names(), ElementsAre("a.json"));
}

TEST(GrowingFile, AppearsWhenItIsComplete) {
  const support::TestFolder folder;
  folder.Write("a.txt", "old");
  {
    GrowingFile file(folder / "a.txt");
    file.Append("one\n");
    file.Append("two\n");
    EXPECT_EQ(support::ReadAll(folder / "a.txt"), "old");
    file.Commit();
  }
  EXPECT_EQ(support::ReadAll(folder / "a.txt"), "one\ntwo\n");
  {
    GrowingFile file(folder / "a.txt");
    file.Append("never");
  }
  EXPECT_EQ(support::ReadAll(folder / "a.txt"), "one\ntwo\n");
  EXPECT_EQ(folder.Names().size(), 1U);
  GrowingFile nameless{std::filesystem::path()};
  nameless.Append("nothing");
  nameless.Commit();
}

}  // namespace
}  // namespace ceilmap::files
