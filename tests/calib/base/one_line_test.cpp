#include "calib/base/one_line.hpp"

#include <gtest/gtest.h>

namespace ceilmap {
namespace {

TEST(InOneLine, JoinsLinesWithOneBlank) {
  EXPECT_EQ(InOneLine("a\nb"), "a b");
  EXPECT_EQ(InOneLine("a \r\n\n  b\n"), "a b");
  EXPECT_EQ(InOneLine("a  b"), "a  b");
  EXPECT_EQ(InOneLine("\n"), "");
  EXPECT_EQ(InOneLine("\x1b[2Ja\x07\tb\x7f"), "?[2Ja?\tb?");  // what would command a terminal
}

TEST(InOneLine, CutsWhatIsTooLong) {
  EXPECT_EQ(InOneLine("abcdef", 6), "abcdef");
  EXPECT_EQ(InOneLine("abcdefg", 6), "abcdef...");
}

TEST(Shown, IsShortAndWithoutControlCharacters) {
  EXPECT_EQ(Shown("a b"), "a b");
  EXPECT_EQ(Shown("\x1b[2J\n"), "?[2J?");
  EXPECT_EQ(Shown("12345", 4), "1234...");
  EXPECT_EQ(Shown("123\xC3\xA4", 4), "123...");  // no half of a character
}

}  // namespace
}  // namespace ceilmap
