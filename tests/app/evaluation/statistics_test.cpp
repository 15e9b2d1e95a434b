#include "app/evaluation/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap::evaluation {
namespace {

TEST(Statistics, OfAbsoluteValues) {
  const ErrorStatistics s = Statistics({-4, 1, 3, 2});
  EXPECT_EQ(s.count, 4);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(30.0 / 4));
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(5.0 / 4));  // of 1, 2, 3, 4
  EXPECT_DOUBLE_EQ(s.min, 1);
  EXPECT_DOUBLE_EQ(s.max, 4);
  EXPECT_DOUBLE_EQ(s.p75, 3.25);  // rank 0.75 * 3 = 2.25, between 3 and 4
  EXPECT_DOUBLE_EQ(s.p90, 3.7);
  EXPECT_DOUBLE_EQ(s.p95, 3.85);
  EXPECT_DOUBLE_EQ(s.p99, 3.97);
}

TEST(Statistics, OfOneValue) {
  const ErrorStatistics s = Statistics(std::vector<double>{-7});
  EXPECT_EQ(s.rmse, 7);
  EXPECT_EQ(s.std, 0);
  EXPECT_EQ(s.min, 7);
  EXPECT_EQ(s.p99, 7);
}

}  // namespace
}  // namespace ceilmap::evaluation
