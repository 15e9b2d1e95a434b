#include "app/evaluation/alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ceilmap::evaluation {
namespace {

using calib::Pose2;

TEST(FitPlanarMotion, RecoversAMotion) {
  const Pose2 T{3, -4, 2.9};
  std::vector<PointPair> pairs;
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0.5), Eigen::Vector2d(-2, 1)}) {
    pairs.push_back({T * p, p});
  }
  const Pose2 fit = FitPlanarMotion(pairs);
  EXPECT_NEAR(fit.x, T.x, 1e-14);
  EXPECT_NEAR(fit.y, T.y, 1e-14);
  EXPECT_NEAR(fit.yaw, T.yaw, 1e-14);
}

TEST(FitPlanarMotion, OnePlaceIsOnlyMoved) {
  const Pose2 fit = FitPlanarMotion({{{1, 2}, {5, 5}}, {{1, 2}, {5, 5}}});
  EXPECT_EQ(fit.Translation(), Eigen::Vector2d(-4, -3));
  EXPECT_EQ(fit.yaw, 0);
}

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
