#include "app/terminal/console.hpp"

#include <gtest/gtest.h>

namespace ceilmap::terminal {
namespace {

TEST(InOneLine, JoinsLinesWithOneBlank) {
  EXPECT_EQ(InOneLine("a\nb"), "a b");
  EXPECT_EQ(InOneLine("a \r\n\n  b\n"), "a b");
  EXPECT_EQ(InOneLine("a  b"), "a  b");
  EXPECT_EQ(InOneLine("\n"), "");
  EXPECT_EQ(InOneLine("\x1b[2Ja\x07\tb\x7f"), "?[2Ja?\tb?");  // what would command a terminal
}

TEST(Console, WritesWhatTheVerbosityAdmits) {
  const auto say_all = [](Verbosity verbosity) {
    SetVerbosity(verbosity);
    testing::internal::CaptureStderr();
    PrintError("e\nf");
    Warn("w {}", 1);
    Note("n {}", 2);
    Detail("d {}", 3);
    std::string text = testing::internal::GetCapturedStderr();
    SetVerbosity(Verbosity::kNormal);
    return text;
  };
  const std::string quiet = "ceilmap: e f\nceilmap: warning: w 1\n";
  EXPECT_EQ(say_all(Verbosity::kQuiet), quiet);
  EXPECT_EQ(say_all(Verbosity::kNormal), quiet + "ceilmap: n 2\n");
  EXPECT_EQ(say_all(Verbosity::kVerbose), quiet + "ceilmap: n 2\nceilmap: d 3\n");
}

TEST(Console, KeepsTheStatusLineBelowMessages) {
  testing::internal::CaptureStderr();
  ShowStatusLine("50 %");
  Note("hello");
  ShowStatusLine("");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "\r\033[K50 %\r\033[Kceilmap: hello\n50 %\r\033[K");
}

}  // namespace
}  // namespace ceilmap::terminal
