#include "app/files/csv.hpp"

#include "app/files/text_file.hpp"
#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

using testing::ElementsAre;

TEST(ReadCsv, UnderstandsQuotesBlankLinesAndForeignLineEnds) {
  const support::TestFolder folder;
  const CsvTable table =
      ReadCsv(folder.Write("t.csv", "\xEF\xBB\xBFid,name\r\n\r\n1 , \"a, \"\"b\"\"\"\r\n2,\n"));
  EXPECT_THAT(table.header, ElementsAre("id", "name"));
  ASSERT_EQ(table.rows.size(), 2U);
  EXPECT_THAT(table.rows[0].fields, ElementsAre("1", "a, \"b\""));
  EXPECT_THAT(table.rows[1].fields, ElementsAre("2", ""));
  EXPECT_EQ(table.rows[0].line, 3);
  EXPECT_EQ(table.Column("name"), 1U);
  EXPECT_TRUE(table.Has("name"));
  EXPECT_FALSE(table.Has("nam"));
  EXPECT_EQ(table.Number(table.rows[1], 0), 2);
}

TEST(ReadCsv, NamesTheFaultyLine) {
  const support::TestFolder folder;
  support::ExpectInputError([&] { ReadCsv(folder / "none.csv"); }, {"none.csv", "no such file"});
  support::ExpectInputError([&] { ReadCsv(folder.Path()); }, {"no such file"});
  support::ExpectInputError([&] { ReadCsv(folder.Write("e.csv", "\n")); }, {"e.csv", "empty"});
  support::ExpectInputError([&] { ReadCsv(folder.Write("r.csv", "a,b\n1,2\n1\n")); },
                            {"r.csv:3", "1 fields", "2"});
  support::ExpectInputError([&] { (void)ReadCsv(folder.Write("c.csv", "a,b\n")).Column("id"); },
                            {"c.csv:1", "'id'"});
  for (const char* field : {"", "x", "nan", "inf"}) {
    const CsvTable table = ReadCsv(folder.Write("n.csv", std::string("a,b\n1,") + field + "\n"));
    support::ExpectInputError([&] { (void)table.Number(table.rows[0], 1); },
                              {"n.csv:2: b '", "is not a number"});
  }
}

std::string MessageOf(const std::string& text, std::size_t max_fields = kMaxCsvFields) {
  try {
    (void)ParseCsv(text, "t.csv", max_fields);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ParseCsv, HasLimits) {
  EXPECT_EQ(MessageOf("a,b\n1,2\n3,4\n", 4), "");
  EXPECT_EQ(MessageOf("a,b\n1,2\n3,4\n", 3), "t.csv:3: more than 3 fields; split the recording");
  EXPECT_EQ(MessageOf("a\n" + std::string(kMaxLineBytes, '1') + "\n"), "");
  EXPECT_EQ(MessageOf("a\n" + std::string(kMaxLineBytes + 1, ',') + "\n"),
            "t.csv:2: is longer than 64 KiB; give a text file");
}

// A field may be long, or command a terminal.
TEST(ParseCsv, ShowsOfAFieldWhatCanBeShown) {
  const CsvTable table = ParseCsv("a,b\n1,\x1b[2J" + std::string(100, 'x') + "\n", "t.csv");
  try {
    (void)table.Number(table.rows[0], 1);
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), "t.csv:2: b '?[2J" + std::string(56, 'x') + "...' is not a number");
  }
}

TEST(CsvField, QuotesOnlyWhereNeeded) {
  EXPECT_EQ(CsvField("plain text"), "plain text");
  EXPECT_EQ(CsvField("a,\"b"), "\"a,\"\"b\"");
}

TEST(ParseNumber, TakesWholeTextsOnly) {
  double number = 0;
  EXPECT_TRUE(ParseNumber("-1.5e3", number));
  EXPECT_EQ(number, -1500);
  EXPECT_TRUE(ParseNumber("+7", number));
  EXPECT_EQ(number, 7);
  for (const char* text : {"", " ", "1 ", "1,5", "0x10", "one", "+-1"}) {
    EXPECT_FALSE(ParseNumber(text, number)) << text;
  }
}

}  // namespace
}  // namespace ceilmap::files
