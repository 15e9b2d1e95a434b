#include "app/terminal/console.hpp"

#include <gtest/gtest.h>

namespace ceilmap::terminal {
namespace {

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
