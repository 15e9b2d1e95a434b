#include "app/files/stamps.hpp"

#include "tests/support/test_folder.hpp"

namespace ceilmap::files {
namespace {

TEST(ReadStamps, FindsTheColumnsByName) {
  const support::TestFolder folder;
  const auto file = folder.Write("f.csv", "timestamp,exposure,index\n10.5,1,3\n10.75,1,4\n");
  EXPECT_THAT(ReadStamps(file), testing::ElementsAre(10.5, 10.75));
}

TEST(ReadStamps, NamesEachFault) {
  const support::TestFolder folder;
  const auto expect = [&folder](const std::string& rows, const std::vector<std::string>& parts) {
    SCOPED_TRACE(rows);
    const auto file = folder.Write("f.csv", "index,timestamp\n" + rows);
    support::ExpectInputError([&] { ReadStamps(file); }, parts);
  };
  expect("", {"f.csv", "no stamps"});
  expect("0,1\n1,1\n", {"f.csv:3", "not later"});
  expect("0,2\n1,1\n", {"f.csv:3", "not later"});
  expect("0,1\n2,2\n", {"f.csv:3", "index 2 after 0"});
  expect("0,1\n1,nan\n", {"f.csv:3", "'nan'"});
  expect("0,inf\n", {"f.csv:2", "'inf'"});
  expect("0,soon\n", {"f.csv:2", "'soon'"});
  expect("0.5,1\n", {"f.csv:2", "'0.5'", "whole number"});
  expect("inf,1\n", {"f.csv:2", "'inf'"});
  expect("0,1,2\n", {"f.csv:2", "3 fields"});
}

TEST(ReadStamps, NeedsBothColumns) {
  const support::TestFolder folder;
  support::ExpectInputError([&] { ReadStamps(folder.Write("f.csv", "0,1\n1,2\n")); },
                            {"f.csv:1", "'index'"});
}

}  // namespace
}  // namespace ceilmap::files
