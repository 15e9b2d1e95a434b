#include "app/recordings/live_queue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

namespace ceilmap::recordings {
namespace {

using testing::ElementsAre;

class LiveQueueTest : public testing::Test {
 protected:
  void Use(const LiveQueueParams& params) { queue_ = LiveQueue(params); }

  /// A frame with the number `next_`, which is its brightness too.
  void Push(double arrival_s, std::optional<double> time_s = {}, bool restarted = false) {
    Frame frame;
    frame.index = next_;
    frame.stamp_s = 1000 + next_;
    frame.arrival_s = arrival_s;
    frame.image = cv::Mat(10, 10, CV_8UC1, cv::Scalar(static_cast<double>(next_++)));
    queue_.Push(std::move(frame), time_s, restarted, spare_);
  }
  std::vector<std::int64_t> TakeAll() {
    std::vector<std::int64_t> taken;
    while (!queue_.Empty()) taken.push_back(queue_.Take().index);
    return taken;
  }

  LiveQueue queue_;
  std::vector<cv::Mat> spare_;
  std::int64_t next_ = 0;
};

TEST_F(LiveQueueTest, OnlyFramesThatWaitTooLongAreDropped) {
  Use({.max_wait_s = 0.25});
  for (int i = 0; i < 4; ++i) Push(0.1 * i);  // the first one waits for 0.3 s
  EXPECT_EQ(queue_.Dropped(), 1);
  ASSERT_EQ(spare_.size(), 1U);
  EXPECT_EQ(spare_[0].at<uchar>(0, 0), 0) << "its memory is used again";
  EXPECT_THAT(TakeAll(), ElementsAre(1, 2, 3));
}

TEST_F(LiveQueueTest, ABurstIsNotDropped) {
  Use({.max_wait_s = 0.1});
  for (int i = 0; i < 50; ++i) Push(5);
  EXPECT_EQ(queue_.Dropped(), 0);
}

TEST_F(LiveQueueTest, WithoutWaitingOnlyTheNewestIsKept) {
  Use({.max_wait_s = 0});
  for (int i = 0; i < 5; ++i) Push(5);
  EXPECT_EQ(queue_.Dropped(), 4);
  EXPECT_THAT(TakeAll(), ElementsAre(4));
}

TEST_F(LiveQueueTest, MemoryIsBounded) {
  Use({.max_bytes = 300});
  for (int i = 0; i < 5; ++i) Push(5);
  EXPECT_THAT(TakeAll(), ElementsAre(2, 3, 4));
}

TEST_F(LiveQueueTest, AConsumerThatStaysBehindGetsOnlyTheNewest) {
  Use({.max_wait_s = 1.5, .max_behind_s = 2});
  double now_s = 0;
  for (int i = 0; i < 20; ++i) {
    Push(now_s);
    Push(now_s + 0.05);
    now_s += 0.1;
    EXPECT_EQ(queue_.Take().index, i);  // one of two
  }
  EXPECT_EQ(queue_.Dropped(), 0);
  Push(2.01);
  EXPECT_EQ(queue_.Dropped(), 20);
  EXPECT_THAT(TakeAll(), ElementsAre(40));
  Push(2.1);  // it has caught up
  Push(3);
  EXPECT_THAT(TakeAll(), ElementsAre(41, 42));
}

TEST_F(LiveQueueTest, FramesAreHeldBackUntilTheirStampsAreKnown) {
  Push(100.1, 7.00);
  EXPECT_FALSE(queue_.Ready(100.1, false));
  EXPECT_TRUE(queue_.Ready(100.1, true)) << "no more will come";
  Push(100.1, 7.04);
  EXPECT_FALSE(queue_.Ready(100.1, false));
  Push(100.12, 7.08);
  EXPECT_TRUE(queue_.Ready(100.12, false));
  EXPECT_NEAR(queue_.Take().stamp_s, 100.04, 1e-9);
  EXPECT_NEAR(queue_.Take().stamp_s, 100.08, 1e-9);
  EXPECT_NEAR(queue_.Take().stamp_s, 100.12, 1e-9);
  EXPECT_FALSE(queue_.Ready(100.12, false));
}

TEST_F(LiveQueueTest, AFrameFromBeforeAnOutageKeepsItsTime) {
  for (int i = 0; i < 3; ++i) Push(100 + 0.04 * i, 7 + 0.04 * i);
  Push(101, 0, true);
  EXPECT_TRUE(queue_.Ready(101, false));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(queue_.Take().stamp_s, 100 + 0.04 * i, 1e-9);
  EXPECT_FALSE(queue_.Ready(101, false)) << "of the new connection the time is not known yet";
  Push(101.04, 0.04);
  EXPECT_NEAR(queue_.Take().stamp_s, 101, 1e-9);
}

TEST_F(LiveQueueTest, TimesThatBeginAnewNeedNoRestart) {
  for (int i = 0; i < 3; ++i) Push(100 + 0.04 * i, 7 + 0.04 * i);
  Push(100.12, 0);
  Push(100.16, 0.04);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(queue_.Take().stamp_s, 100 + 0.04 * i, 1e-9);
}

TEST_F(LiveQueueTest, GivenStampsStay) {
  Use({.stamp = false});
  Push(100, 7);
  EXPECT_TRUE(queue_.Ready(100, false));
  EXPECT_EQ(queue_.Take().stamp_s, 1000);
}

}  // namespace
}  // namespace ceilmap::recordings
