#include "app/terminal/progress.hpp"

#include <gtest/gtest.h>

namespace ceilmap::terminal {
namespace {

TEST(FormatProgress, ShowsBarRateAndTimeLeft) {
  EXPECT_EQ(FormatProgress("mapping", "frames", 100, 400, 2),
            "mapping  [######..................]  100/400 frames  50.0/s  6.0 s left");
}

TEST(FormatProgress, WithoutATotalThereIsNoBar) {
  EXPECT_EQ(FormatProgress("mapping", "frames", 7, std::nullopt, 2), "mapping  7 frames  3.5/s");
}

TEST(FormatProgress, CopesWithStartEndAndTooMany) {
  EXPECT_EQ(FormatProgress("m", "f", 0, 10, 0), "m  [........................]  0/10 f  0.0/s");
  EXPECT_EQ(FormatProgress("m", "f", 10, 10, 5), "m  [########################]  10/10 f  2.0/s");
  EXPECT_EQ(FormatProgress("m", "f", 12, 10, 6), "m  [########################]  12/10 f  2.0/s");
}

TEST(FormatProgress, CountsSlowWorkByTheMinuteOrHour) {
  EXPECT_EQ(FormatProgress("m", "f", 3, 6, 60),
            "m  [############............]  3/6 f  3.0/min  1 min 00 s left");
  EXPECT_EQ(FormatProgress("m", "f", 1, std::nullopt, 3600), "m  1 f  1.0/h");
}

TEST(FormatDuration, GrowsCoarser) {
  EXPECT_EQ(FormatDuration(4.24), "4.2 s");
  EXPECT_EQ(FormatDuration(59.99), "1 min 00 s");
  EXPECT_EQ(FormatDuration(185), "3 min 05 s");
  EXPECT_EQ(FormatDuration(3725), "1 h 02 min");
}

TEST(Progress, WritesNothingWhereStderrIsNoTerminal) {
  testing::internal::CaptureStderr();
  {
    Progress progress("mapping", "frames", 10);
    progress.Update(5);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace ceilmap::terminal
