#include "app/files/text_file.hpp"

#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

TEST(ReadTextFile, HasALimit) {
  const support::TestFolder folder;
  const std::string text((1U << 20U) + 1, 'x');
  const auto file = folder.Write("t", text);
  EXPECT_EQ(ReadTextFile(file), text);
  EXPECT_EQ(ReadTextFile(file, text.size()), text);
  support::ExpectInputError(
      [&] { ReadTextFile(file, 1U << 20U); },
      {(folder / "t").string() +
       ": larger than 1 MiB, the most that a text file may have; split the recording"});
  // A device without end, of unknown size.
  support::ExpectInputError([&] { ReadTextFile("/dev/zero", 1U << 20U); },
                            {"/dev/zero: larger than 1 MiB"});
  support::ExpectInputError([&] { ReadTextFile(folder.Path()); },
                            {"no such file, or not readable"});
}

TEST(Lines, AreCountedAndHaveNoEnds) {
  const std::string name = "t";
  Lines lines("a\n\nb\r\nc", name);
  std::vector<std::string> read;
  std::string_view line;
  while (lines.Next(line)) read.emplace_back(line);
  EXPECT_THAT(read, testing::ElementsAre("a", "", "b\r", "c"));
  EXPECT_EQ(lines.Number(), 4);
  EXPECT_FALSE(Lines("", name).Next(line));
}

}  // namespace
}  // namespace ceilmap::files
