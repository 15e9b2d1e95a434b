#include "app/recordings/message_times.hpp"

#include <gmock/gmock.h>

namespace ceilmap::recordings {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(MessageTimes, SecondsAreAsExactAsADoubleIs) {
  EXPECT_EQ(SecondsOf(0), 0);
  EXPECT_EQ(SecondsOf(-1'500'000'000), -1.5);
  EXPECT_EQ(SecondsOf(1'700'000'000'500'000'000), 1'700'000'000.5);
  EXPECT_NEAR(SecondsOf(1'700'000'000'123'456'789) - 1.7e9, 0.123456789, 2.4e-7);
}

TEST(MessageTimes, AreThoseOfTheHeaderOrOfTheLog) {
  MessageTimes header(BagStamp::kHeader);
  EXPECT_EQ(header.Of(5 * kSecond, 9 * kSecond), 5 * kSecond);
  EXPECT_EQ(header.Of(6 * kSecond, 9 * kSecond), 6 * kSecond);
  EXPECT_EQ(header.Replaced(), 0);
  MessageTimes log(BagStamp::kLog);
  EXPECT_EQ(log.Of(0, 9 * kSecond), 9 * kSecond);
  EXPECT_EQ(log.Of(7 * kSecond, 10 * kSecond), 10 * kSecond);
  EXPECT_EQ(log.Of(8 * kSecond, 10 * kSecond), 10 * kSecond + 1'000'000);
  EXPECT_EQ(log.Replaced(), 0);
}

TEST(MessageTimes, AHeaderWithoutATimeTakesThatOfTheLog) {
  MessageTimes times(BagStamp::kHeader);
  EXPECT_EQ(times.Of(0, 100 * kSecond), 100 * kSecond);
  EXPECT_EQ(times.Of(0, 101 * kSecond), 101 * kSecond);
  EXPECT_EQ(times.Replaced(), 2);
}

TEST(MessageTimes, AHeaderThatDoesNotRiseGoesOnByTheLog) {
  MessageTimes times(BagStamp::kHeader);
  EXPECT_EQ(times.Of(5 * kSecond, 100 * kSecond), 5 * kSecond);
  EXPECT_EQ(times.Of(5 * kSecond, 102 * kSecond), 7 * kSecond);
  EXPECT_EQ(times.Of(7 * kSecond, 101 * kSecond), 7 * kSecond + 1'000'000) << "the log went back";
  EXPECT_EQ(times.Of(8 * kSecond, 103 * kSecond), 8 * kSecond);
  EXPECT_EQ(times.Replaced(), 2);
}

// With a stamp by the log it would have a pose at a wrong time.
TEST(MessageTimes, AMessageThatWasRecordedLateIsLeftOut) {
  constexpr std::int64_t kTenth = kSecond / 10;
  MessageTimes times(BagStamp::kHeader);
  EXPECT_EQ(times.Of(50 * kTenth, 1000 * kTenth), 50 * kTenth);
  EXPECT_EQ(times.Of(52 * kTenth, 1002 * kTenth), 52 * kTenth);
  EXPECT_EQ(times.Of(51 * kTenth, 1003 * kTenth), std::nullopt);
  EXPECT_EQ(times.Of(53 * kTenth, 1004 * kTenth), 53 * kTenth);
  EXPECT_EQ(times.Late(), 1);
  EXPECT_EQ(times.Replaced(), 0);
}

TEST(MessageTimes, AClockThatWasSetBackGoesOnByTheLogAfterASecond) {
  constexpr std::int64_t kTenth = kSecond / 10;
  MessageTimes times(BagStamp::kHeader);
  EXPECT_EQ(times.Of(500 * kTenth, 1000 * kTenth), 500 * kTenth);
  for (int i = 1; i < 10; ++i) {
    EXPECT_EQ(times.Of((100 + i) * kTenth, (1000 + i) * kTenth), std::nullopt) << i;
  }
  for (int i = 10; i < 30; ++i) {
    EXPECT_EQ(times.Of((100 + i) * kTenth, (1000 + i) * kTenth), (500 + i) * kTenth) << i;
  }
  EXPECT_EQ(times.Late(), 9);
  EXPECT_EQ(times.Replaced(), 20);
}

}  // namespace
}  // namespace ceilmap::recordings
