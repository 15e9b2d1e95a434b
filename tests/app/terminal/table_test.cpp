#include "app/terminal/table.hpp"

#include <gtest/gtest.h>

namespace ceilmap::terminal {
namespace {

TEST(Table, AlignsWordsToTheLeftAndNumbersToTheRight) {
  Table table;
  table.AddRow({"name", "value", "unit"});
  table.AddRow({"path", "-1.5", "m"});
  table.AddRow({"frames", "12"});
  EXPECT_EQ(table.Format(),
            "name    value  unit\n"
            "path     -1.5  m\n"
            "frames     12\n");
  EXPECT_EQ(table.Format(Table::Numbers::kLeft),
            "name    value  unit\n"
            "path    -1.5   m\n"
            "frames  12\n");
}

TEST(Table, EmptyIsEmpty) {
  EXPECT_EQ(Table().Format(), "");
}

}  // namespace
}  // namespace ceilmap::terminal
