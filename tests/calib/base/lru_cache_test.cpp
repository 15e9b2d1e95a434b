#include "calib/base/lru_cache.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace ceilmap {
namespace {

TEST(LruCache, DropsWhatWasUsedLongestAgo) {
  LruCache<int> cache(2);
  cache.Insert(1, 10);
  cache.Insert(2, 20);
  ASSERT_NE(cache.Find(1), nullptr);
  cache.Insert(3, 30);
  EXPECT_EQ(cache.Find(2), nullptr);
  ASSERT_NE(cache.Find(1), nullptr);
  EXPECT_EQ(*cache.Find(1), 10);
  EXPECT_EQ(*cache.Find(3), 30);
}

TEST(LruCache, VisitsAllButTheLatest) {
  LruCache<int> cache(4);
  for (int i = 1; i <= 4; ++i) cache.Insert(i, 10 * i);
  (void)cache.Find(1);  // now the latest
  std::vector<int> visited;
  cache.ForEachBut(2, [&visited](int& value) {
    visited.push_back(value);
    ++value;
  });
  EXPECT_EQ(visited, (std::vector<int>{30, 20}));
  EXPECT_EQ(*cache.Find(3), 31);
  EXPECT_EQ(*cache.Find(4), 40);
  cache.ForEachBut(4, [](const int&) { ADD_FAILURE(); });
}

}  // namespace
}  // namespace ceilmap
