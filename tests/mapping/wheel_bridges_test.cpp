#include "mapping/wheel_bridges.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <vector>

namespace ceilmap::mapping {
namespace {

wheels::RelativeMotion HalfAMetre() {
  wheels::RelativeMotion step;
  step.T_before_now = {0.5, 0, 0};
  step.travel_m = 0.5;
  return step;
}

graph::Edge EdgeTo(std::int64_t id, graph::Edge::Kind kind) {
  graph::Edge edge;
  edge.from = id - 1;
  edge.to = id;
  edge.kind = kind;
  edge.information = 1e4 * Eigen::Matrix3d::Identity();  // 1 cm
  return edge;
}

/// A keyframe, two metres in the dark, and keyframe 3.
struct DarkDrive {
  std::vector<graph::Edge> edges = {EdgeTo(2, graph::Edge::Kind::kOdometry),
                                    EdgeTo(3, graph::Edge::Kind::kWheels)};
  WheelBridges bridges;

  DarkDrive() {
    bridges.Follow(true, {edges[0]}, HalfAMetre());
    for (int i = 0; i < 3; ++i) bridges.Follow(false, {}, HalfAMetre());
    bridges.Follow(true, {edges[1]}, HalfAMetre());
    bridges.Follow(true, {}, HalfAMetre());
  }
  [[nodiscard]] Eigen::Vector3d Variances(std::size_t edge) const {
    return edges[edge].information.inverse().diagonal();
  }
};

TEST(WheelBridges, LaterSlipsCountInTheDarkToo) {
  DarkDrive drive;
  drive.bridges.TakeSlips({0.1, 0.2});
  drive.bridges.Correct(drive.edges);
  const double expected = 1e-4 + 0.2 * 0.2 + 0.2 * 0.2 * 2;  // two metres
  EXPECT_NEAR(drive.Variances(1)[0], expected, 1e-9);
  EXPECT_NEAR(drive.Variances(1)[1], expected, 1e-9);
  EXPECT_NEAR(drive.Variances(1)[2], 1e-4, 1e-9);
  EXPECT_NEAR(drive.Variances(0)[0], 1e-4, 1e-9) << "seen";
}

TEST(WheelBridges, WithoutSlipsNothingChanges) {
  DarkDrive drive;
  drive.bridges.TakeSlips({});
  drive.bridges.Correct(drive.edges);
  ASSERT_EQ(drive.edges.size(), 2U);
  EXPECT_EQ(drive.edges[1].information, 1e4 * Eigen::Matrix3d::Identity());
}

TEST(WheelBridges, WrongWheelsConnectNothing) {
  DarkDrive drive;
  drive.bridges.Forget();
  drive.bridges.Correct(drive.edges);
  ASSERT_EQ(drive.edges.size(), 1U);
  EXPECT_EQ(drive.edges[0].kind, graph::Edge::Kind::kOdometry);
}

}  // namespace
}  // namespace ceilmap::mapping
