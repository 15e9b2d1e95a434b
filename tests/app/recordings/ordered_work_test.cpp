#include "app/recordings/ordered_work.hpp"

#include <gmock/gmock.h>

#include <atomic>
#include <stdexcept>
#include <thread>

namespace ceilmap::recordings {
namespace {

TEST(OrderedWork, HandsResultsOutInOrder) {
  OrderedWork<std::int64_t> work(200, 4, [](std::int64_t i) {
    if (i % 3 == 0) std::this_thread::yield();
    return i * i;
  });
  for (std::int64_t i = 0; i < 200; ++i) EXPECT_EQ(work.Next(), i * i);
  EXPECT_EQ(work.Next(), std::nullopt);
  EXPECT_EQ(work.Next(), std::nullopt);
}

TEST(OrderedWork, StaysCloseToItsConsumer) {
  std::atomic<std::int64_t> begun = 0;
  OrderedWork<int> work(100, 3, [&begun](std::int64_t) {
    ++begun;
    return 0;
  });
  for (std::int64_t taken = 1; taken <= 100; ++taken) {
    ASSERT_TRUE(work.Next().has_value());
    EXPECT_LE(begun, taken + 6);
  }
}

TEST(OrderedWork, ThrowsWhatTheJobThrew) {
  OrderedWork<std::int64_t> work(10, 2, [](std::int64_t i) {
    if (i == 3) throw std::runtime_error("the fourth");
    return i;
  });
  for (std::int64_t i = 0; i < 3; ++i) EXPECT_EQ(work.Next(), i);
  EXPECT_THROW((void)work.Next(), std::runtime_error);
  EXPECT_EQ(work.Next(), 4);
}

TEST(OrderedWork, CanBeLeftEarly) {
  std::atomic<int> done = 0;
  {
    OrderedWork<int> work(1000000, 2, [&done](std::int64_t) { return ++done; });
    (void)work.Next();
  }
  EXPECT_LE(done, 5);
}

TEST(OrderedWork, OfNothingEndsAtOnce) {
  OrderedWork<int> work(0, 2, [](std::int64_t) { return 1; });
  EXPECT_EQ(work.Next(), std::nullopt);
}

}  // namespace
}  // namespace ceilmap::recordings
