#include "app/evaluation/association.hpp"

#include <gtest/gtest.h>

namespace ceilmap::evaluation {
namespace {

TEST(MatchStamps, NearestWithinTheLimit) {
  const auto at = [](const std::vector<double>& stamps_s) {
    std::vector<StampedPose> poses;
    for (const double stamp_s : stamps_s) poses.push_back(ToStampedPose(stamp_s, {}));
    return poses;
  };
  using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
  EXPECT_EQ(MatchStamps(at({0, 1, 2}), at({0.5, 1.01, 2.5, 7}), 0.02), (Pairs{{1, 1}}));
  EXPECT_EQ(MatchStamps(at({0, 1, 2}), at({0, 0.75, 2}), 0.25), (Pairs{{0, 0}, {1, 1}, {2, 2}}));
  EXPECT_EQ(MatchStamps(at({0, 1}), at({5}), 1), Pairs{});
}

}  // namespace
}  // namespace ceilmap::evaluation
