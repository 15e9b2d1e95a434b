#include "app/recordings/frame_tree.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/test_bag.hpp"

namespace ceilmap::recordings {
namespace {

using support::Link;

const double kHalf = std::sqrt(0.5);
/// The axes of a camera that looks ahead, in REP-103: z ahead, x to the right, y down.
const std::array<double, 4> kOptical = {-0.5, 0.5, -0.5, 0.5};

TEST(FrameTree, ComposesChains) {
  FrameTree tree;
  EXPECT_TRUE(tree.Empty());
  tree.Add(Link("base_link", "mast", {0.1, 0, 0.4}, {0, 0, kHalf, kHalf}));  // 90 deg left
  tree.Add(Link("mast", "camera", {0.2, 0, 0}));
  tree.Add(Link("camera", "camera_optical", {0, 0, 0}, kOptical));
  tree.Add(Link("base_link", "laser", {0, 0, 0.3}));
  const auto T = tree.Find("base_link", "camera_optical");
  ASSERT_TRUE(T.has_value());
  EXPECT_TRUE(T->translation().isApprox(Eigen::Vector3d(0.1, 0.2, 0.4)));
  // It looks to the left: z along +y, x along +x, y down.
  EXPECT_TRUE(T->linear().col(2).isApprox(Eigen::Vector3d(0, 1, 0)));
  EXPECT_TRUE(T->linear().col(0).isApprox(Eigen::Vector3d(1, 0, 0)));
  EXPECT_TRUE(T->linear().col(1).isApprox(Eigen::Vector3d(0, 0, -1)));
  EXPECT_TRUE(tree.Find("camera_optical", "base_link")->isApprox(T->inverse()));
  // Between two branches.
  EXPECT_TRUE(tree.Find("laser", "mast")->translation().isApprox(Eigen::Vector3d(0.1, 0, 0.1)));
  EXPECT_FALSE(tree.Find("base_link", "odom").has_value());
  EXPECT_TRUE(tree.Find("odom", "odom")->isApprox(Eigen::Isometry3d::Identity()));
}

TEST(FrameTree, NamesOfRos1BeginWithASlash) {
  FrameTree tree;
  tree.Add(Link("/base_link", "/camera", {1, 2, 3}));
  EXPECT_TRUE(tree.Find("base_link", "camera")->translation().isApprox(Eigen::Vector3d(1, 2, 3)));
}

TEST(FrameTree, TheBaseIsThatOnTheFloor) {
  FrameTree tree;
  tree.Add(Link("base_link", "camera", {0, 0, 1}));
  EXPECT_EQ(tree.BaseOf("camera"), "base_link");
  EXPECT_EQ(tree.BaseOf("laser"), std::nullopt);
  FrameTree above = tree;
  above.Add(Link("base_footprint", "base_link", {0, 0, 0.1}));
  EXPECT_EQ(above.BaseOf("camera"), "base_footprint");
  FrameTree below = tree;
  below.Add(Link("base_link", "base_footprint", {0, 0, -0.1}));
  EXPECT_EQ(below.BaseOf("camera"), "base_footprint");
  EXPECT_NEAR(below.Find("base_footprint", "camera")->translation().z(), 1.1, 1e-12);
  FrameTree named;
  named.Add(Link("robot_1/base_link", "robot_1/camera", {0, 0, 1}));
  EXPECT_EQ(named.BaseOf("robot_1/camera"), "robot_1/base_link");
}

TEST(FrameTree, IgnoresWhatIsNoPoseAndEndsInALoop) {
  FrameTree tree;
  tree.Add(Link("base_link", "zero", {0, 0, 0}, {0, 0, 0, 0}));
  tree.Add(Link("base_link", "nan", {std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  EXPECT_TRUE(tree.Empty());
  tree.Add(Link("a", "b", {1, 0, 0}));
  tree.Add(Link("b", "a", {1, 0, 0}));
  EXPECT_FALSE(tree.Find("base_link", "a").has_value());
  EXPECT_FALSE(tree.BaseOf("a").has_value());
}

}  // namespace
}  // namespace ceilmap::recordings
