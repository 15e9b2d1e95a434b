#include "calib/base/statistics.hpp"

#include <gtest/gtest.h>

namespace ceilmap {
namespace {

TEST(Median, IsTheMiddleByRank) {
  EXPECT_EQ(Median({3, 1, 2}), 2);
  EXPECT_EQ(Median({7}), 7);
}

TEST(Median, OfAnEvenNumberIsTheUpperOfTheTwo) {
  EXPECT_EQ(Median({4, 1, 3, 2}), 3);
}

TEST(Median, OfNothingIsZero) {
  EXPECT_EQ(Median({}), 0);
}

}  // namespace
}  // namespace ceilmap
