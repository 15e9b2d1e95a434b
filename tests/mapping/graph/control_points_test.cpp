#include "mapping/graph/control_points.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/base/error.hpp"
#include "tests/mapping/graph/bent_corridor.hpp"

namespace ceilmap::graph {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

using synthetic::Corridor;

TEST(Straighten, ABentCorridorBecomesStraight) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Corridor corridor(seed);
    EXPECT_GT(corridor.Bend(), 0.4);
    Straighten(corridor.graph, corridor.Points(0.002), corridor.site);
    // What is left is the curvature between two points: 3 mm by geometry, and their noise.
    EXPECT_LT(corridor.Bend(), 0.008) << seed;
    // The direction at the ends is known to some milliradians, and the points lie 1 m aside.
    EXPECT_NEAR(corridor.Length(), 60, 0.02) << seed;
  }
}

TEST(Straighten, ExactPointsOfAStraightMapChangeNothing) {
  Corridor corridor(3, 0);
  const std::vector<Pose2> before = PosesById(corridor.graph);
  std::vector<ControlMeasurement> points;
  for (const std::int64_t id : {0, 40, 80, 120}) {
    const Eigen::Vector2d p_base(0, 1);
    points.push_back(
        {id, p_base, corridor.site * (before[static_cast<std::size_t>(id)] * p_base), 0.01});
  }
  Straighten(corridor.graph, points, corridor.site);
  const std::vector<Pose2> after = PosesById(corridor.graph);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR((before[i].Translation() - after[i].Translation()).norm(), 0, 1e-6);
  }
}

TEST(Straighten, AWrongPointIsNotUsed) {
  Corridor corridor(4, 0.00005);
  std::vector<ControlMeasurement> points = corridor.Points(0.003);
  Corridor same(4, 0.00005);
  std::vector<ControlMeasurement> without = points;
  without.erase(without.begin() + 3);
  points[3].p_site.x() += 0.5;
  const std::vector<bool> used = Straighten(corridor.graph, points, corridor.site);
  for (std::size_t i = 0; i < used.size(); ++i) EXPECT_EQ(used[i], i != 3) << i;
  Straighten(same.graph, without, same.site);
  for (std::size_t i = 0; i < corridor.graph.keyframes.size(); ++i) {
    EXPECT_NEAR((corridor.graph.keyframes[i].pose.T_map_base.Translation() -
                 same.graph.keyframes[i].pose.T_map_base.Translation())
                    .norm(),
                0,
                1e-6);
  }
}

TEST(Straighten, FramesFollowTheirKeyframes) {
  Corridor corridor(5);
  Straighten(corridor.graph, corridor.Points(0.003), corridor.site);
  for (std::size_t i = 0; i < corridor.graph.keyframes.size(); ++i) {
    const Pose2& keyframe = corridor.graph.keyframes[i].pose.T_map_base;
    const Pose2& frame = corridor.graph.trajectory[i].T_map_base;
    EXPECT_NEAR((keyframe.Translation() - frame.Translation()).norm(), 0, 1e-9);
  }
  EXPECT_TRUE(corridor.graph.keyframes.back().pose.covariance.allFinite());
}

TEST(Straighten, RefusesAPointOfAMissingKeyframe) {
  Corridor corridor(6);
  const std::vector<ControlMeasurement> points = {{999, {0, 0}, {1, 2}, 0.01}};
  EXPECT_THAT([&] { Straighten(corridor.graph, points, corridor.site); },
              ThrowsMessage<InputError>(HasSubstr("keyframe 999")));
}

}  // namespace
}  // namespace ceilmap::graph
