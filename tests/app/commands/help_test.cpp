#include "app/commands/help.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/test_folder.hpp"

namespace ceilmap::commands {
namespace {

TEST(Help, KnowsItsTopicsInAnyCase) {
  for (const std::string& topic : HelpTopics()) EXPECT_TRUE(HelpOn(topic)) << topic;
  EXPECT_EQ(HelpOn("FILES"), HelpOn("files"));
  EXPECT_EQ(HelpOn("map"), std::nullopt);
}

TEST(Help, OnFilesIsTheMarkdownFile) {
  EXPECT_EQ(HelpOn("files"),
            support::ReadAll(std::filesystem::path(CEILMAP_SOURCE_DIR) / "app/FILES.md"));
}

TEST(Help, OnTroubleshootingHasEachRowOfTheTable) {
  const std::string text = HelpOn("troubleshooting").value();
  EXPECT_THAT(text, testing::HasSubstr("\n...: exists already; give --force to replace it, or"));
  EXPECT_THAT(text, testing::HasSubstr("\ngnuplot ... is not installed\n    Figures cannot be"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("|"))) << "no table is left";
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("##"))) << "only this section";
  std::istringstream lines(text);
  int rows = 0;
  for (std::string line; std::getline(lines, line);) rows += line.starts_with("    ") ? 0 : 1;
  EXPECT_GT(rows, 20);
}

TEST(TableAsParagraphs, IndentsAllCellsButTheFirst) {
  EXPECT_EQ(
      TableAsParagraphs("Before.\n\n| a | b | c |\n|---|---|---|\n| no map | lost | go back |\n"
                        "| x | y | z |\nBehind.\n"),
      "Before.\n\nno map\n    lost\n    go back\n\nx\n    y\n    z\n\nBehind.\n");
}

TEST(TableAsParagraphs, BreaksLongCells) {
  const std::string words =
      "0123456789 0123456789 0123456789 0123456789 0123456789 0123456789 "
      "0123456789 ";
  EXPECT_EQ(TableAsParagraphs("|a|b|\n|-|-|\n|x|" + words + "0123456789|\n"),
            "x\n    " + words.substr(0, words.size() - 1) + "\n    0123456789\n\n");
}

}  // namespace
}  // namespace ceilmap::commands
