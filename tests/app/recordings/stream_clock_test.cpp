#include "app/recordings/stream_clock.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace ceilmap::recordings {
namespace {

using Times = StreamClock::Times;
using testing::DoubleNear;
using testing::ElementsAre;

constexpr double kIntervalS = 0.04;
constexpr double kTightS = 1e-9;

/// Frame `index` of a stream that began at 7 s of its own time and at 100 s of the clock.
Times OnTime(int index, double delay_s = 0) {
  return {index, 7 + index * kIntervalS, 100 + index * kIntervalS + delay_s};
}

double Add(StreamClock& clock, const Times& frame) {
  clock.Arrive(frame);
  return clock.Stamp(frame);
}

TEST(StreamClock, DelaysDoNotReachTheStamps) {
  StreamClock clock;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> delay(0, 0.03);
  Add(clock, OnTime(0));
  for (int i = 1; i < 1000; ++i) {
    const double extra_s = i % 20 == 0 ? 0 : delay(random);
    EXPECT_NEAR(Add(clock, OnTime(i, extra_s)), 100 + i * kIntervalS, kTightS) << i;
  }
}

TEST(StreamClock, AGapOfTheSenderIsAGapOfTheStamps) {
  StreamClock clock;
  for (int i = 0; i < 20; ++i) Add(clock, OnTime(i));
  EXPECT_EQ(clock.Missing(), 0);
  Times late = OnTime(23);
  late.index = 20;
  EXPECT_NEAR(Add(clock, late), 100 + 23 * kIntervalS, kTightS);
  EXPECT_EQ(clock.Missing(), 3);
}

TEST(StreamClock, FramesThatWereLeftOutAsDamagedAreNotMissing) {
  StreamClock clock;
  for (int i = 0; i < 20; ++i) Add(clock, OnTime(i));
  Add(clock, OnTime(24));
  EXPECT_EQ(clock.Missing(), 0);
}

TEST(StreamClock, MissingFollowsTheRateOfTheCamera) {
  StreamClock clock;
  int index = 0;
  double time_s = 0;
  for (const double period_s : {0.04, 0.08}) {
    for (int i = 0; i < 40; ++i) Add(clock, {index++, time_s += period_s, 100 + time_s});
  }
  EXPECT_EQ(clock.Missing(), 16) << "half of the window is of the earlier rate";
  for (int i = 0; i < 100; ++i) Add(clock, {index++, time_s += 0.08, 100 + time_s});
  EXPECT_EQ(clock.Missing(), 16);
}

TEST(StreamClock, TheFirstBurstWaitsUntilItsTimeIsKnown) {
  StreamClock clock;
  std::vector<Times> burst;
  for (int i = 0; i < 12; ++i) {  // all arrive with the last of them
    Times frame = OnTime(i);
    frame.arrival_s = 100 + 11 * kIntervalS + i * 1e-4;
    clock.Arrive(frame);
    EXPECT_FALSE(clock.Settled(frame.arrival_s)) << i;
    burst.push_back(frame);
  }
  clock.Arrive(OnTime(12));
  EXPECT_TRUE(clock.Settled(100 + 12 * kIntervalS));
  for (int i = 0; i < 12; ++i)
    EXPECT_NEAR(clock.Stamp(burst[i]), 100 + i * kIntervalS, kTightS) << i;
}

TEST(StreamClock, WaitsAQuarterOfASecondAtMost) {
  StreamClock clock;
  EXPECT_TRUE(clock.Settled(99));
  clock.Arrive(OnTime(0));
  EXPECT_FALSE(clock.Settled(100.24));
  EXPECT_TRUE(clock.Settled(100.26));
}

TEST(StreamClock, WithoutPresentationTimesTheArrivalCounts) {
  StreamClock clock;
  EXPECT_EQ(Add(clock, {0, std::nullopt, 100}), 100);
  EXPECT_FALSE(clock.Settled(100)) << "times may follow";
  EXPECT_EQ(Add(clock, {1, std::nullopt, 100.07}), 100.07);
  EXPECT_TRUE(clock.Settled(100.07));
  EXPECT_NEAR(Add(clock, {2, std::nullopt, 100.07}), 100.071, kTightS) << "stamps increase";
  EXPECT_EQ(clock.Missing(), std::nullopt);
}

TEST(StreamClock, AFrameWithoutItsTimeIsPutBesideTheOthers) {
  StreamClock clock;
  const Times first{0, std::nullopt, 100.1};
  clock.Arrive(first);
  std::vector<Times> others;
  for (int i = 1; i < 4; ++i) others.push_back(OnTime(i, i == 3 ? 0 : 0.05));
  for (const Times& frame : others) clock.Arrive(frame);
  EXPECT_NEAR(clock.Stamp(first), 100, kTightS);
  for (int i = 1; i < 4; ++i)
    EXPECT_NEAR(clock.Stamp(others[i - 1]), 100 + i * kIntervalS, kTightS);
  EXPECT_NEAR(Add(clock, {4, std::nullopt, 100.9}), 100 + 4 * kIntervalS, kTightS);
  EXPECT_NEAR(Add(clock, OnTime(5)), 100 + 5 * kIntervalS, kTightS);
}

TEST(StreamClock, TheTimesOfACameraOfThisMachineAreTheStamps) {
  StreamClock clock(true);
  EXPECT_EQ(Add(clock, {0, 99.98, 100}), 99.98);
  EXPECT_TRUE(clock.Settled(100));
  EXPECT_EQ(Add(clock, {1, 100.05, 100.051}), 100.05);
}

TEST(StreamClock, ASmallerDelayMovesTheStampsByHalfAnIntervalAtMost) {
  StreamClock clock;
  std::vector<double> stamps_s;
  for (int i = 0; i < 3; ++i) stamps_s.push_back(Add(clock, OnTime(i, 0.05)));
  for (int i = 3; i < 7; ++i) stamps_s.push_back(Add(clock, OnTime(i)));
  EXPECT_THAT(stamps_s,
              ElementsAre(DoubleNear(100.05, kTightS),
                          DoubleNear(100.09, kTightS),
                          DoubleNear(100.13, kTightS),
                          DoubleNear(100.15, kTightS),
                          DoubleNear(100.17, kTightS),
                          DoubleNear(100.20, kTightS),
                          DoubleNear(100.24, kTightS)));
}

TEST(StreamClock, FollowsASenderWhoseClockIsSlow) {
  constexpr double kSlow = 0.99;
  StreamClock clock;
  double stamp_s = 0;
  for (int i = 0; i < 2500; ++i) {
    stamp_s = Add(clock, {i, kSlow * i * kIntervalS, 100 + i * kIntervalS});
  }
  // Never later than the arrival, and at most 10 s of the drift behind it.
  EXPECT_LE(stamp_s, 100 + 2499 * kIntervalS);
  EXPECT_GE(stamp_s, 100 + 2499 * kIntervalS - 0.105);
}

TEST(StreamClock, BeginsAnewWhereTheTimesDo) {
  StreamClock clock;
  for (int i = 0; i < 10; ++i) Add(clock, OnTime(i));
  EXPECT_FALSE(clock.Breaks({10, 7 + 10 * kIntervalS, 100.4}));
  const Times again{10, 2, 103};
  EXPECT_TRUE(clock.Breaks(again));
  clock.Restart();
  EXPECT_FALSE(clock.Breaks(again));
  EXPECT_EQ(Add(clock, again), 103);
  EXPECT_FALSE(clock.Settled(103.01)) << "a burst may follow";
  EXPECT_NEAR(Add(clock, {11, 2 + kIntervalS, 103 + kIntervalS}), 103 + kIntervalS, kTightS);
  EXPECT_EQ(clock.Missing(), 0) << "an outage is not counted in frames";
}

TEST(StreamClock, StampsIncreaseOverARestart) {
  StreamClock clock;
  EXPECT_EQ(Add(clock, {0, 7, 100}), 100);
  clock.Restart();
  EXPECT_NEAR(Add(clock, {1, 3, 100}), 100.001, kTightS);
}

}  // namespace
}  // namespace ceilmap::recordings
