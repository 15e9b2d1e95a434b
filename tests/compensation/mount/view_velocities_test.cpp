#include "compensation/mount/view_velocities.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

namespace ceilmap::mount {
namespace {

using calibration::ViewVelocity;
using Eigen::Vector2d;

/// A camera at (0.2, 0) of a robot that turns on the spot, faster and faster.
double HeadingAt(double time_s) {
  return 0.4 * time_s + 0.05 * time_s * time_s;
}
double RateAt(double time_s) {
  return 0.4 + 0.1 * time_s;
}
Pose2 CameraAt(double time_s) {
  const Pose2 axle{0, 0, HeadingAt(time_s)};
  const Vector2d at = axle * Vector2d(0.2, 0);
  return {at.x(), at.y(), axle.yaw};
}
/// In the camera's axes it moves along y.
void ExpectVelocity(const ViewVelocity& velocity, double time_s, double max_error) {
  EXPECT_NEAR(velocity.yaw_rad_s, RateAt(time_s), max_error);
  EXPECT_NEAR(velocity.linear.x(), 0, max_error);
  EXPECT_NEAR(velocity.linear.y(), 0.2 * RateAt(time_s), max_error);
}

std::vector<TimedPose> Path(double interval_s, double duration_s) {
  std::vector<TimedPose> path;
  for (int i = 0; i * interval_s <= duration_s; ++i) {
    path.push_back({i * interval_s, CameraAt(i * interval_s)});
  }
  return path;
}

TEST(ViewVelocities, AreThoseOfTheImagesNearby) {
  const std::vector<TimedPose> path = Path(1 / 30.0, 12);
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{150}, path.size() - 1}) {
    ExpectVelocity(VelocityAt(path, i), path[i].stamp_s, 0.002);
  }
}

TEST(ViewVelocities, OfViewsAlone) {
  const std::vector<TimedPose> path = Path(0.15, 3);
  const std::vector<ViewVelocity> velocities = VelocitiesOf(path);
  ASSERT_EQ(velocities.size(), path.size());
  for (const std::size_t i : {std::size_t{0}, std::size_t{7}, path.size() - 1}) {
    ExpectVelocity(velocities[i], path[i].stamp_s, 0.005);
  }
}

TEST(ViewVelocities, OfFewImages) {
  const std::vector<TimedPose> slow = Path(0.25, 1);
  ExpectVelocity(VelocityAt(slow, 2), 0.5, 0.01);
  const ViewVelocity of_two = VelocityAt({slow[0], slow[1]}, 0);
  EXPECT_NEAR(of_two.yaw_rad_s, HeadingAt(0.25) / 0.25, 1e-12);
  EXPECT_EQ(VelocityAt({slow[0]}, 0).yaw_rad_s, 0);
}

/// By a wrong tilt the path of the images is another circle, in another scale.
TEST(ViewVelocities, FollowTheAccuratePoses) {
  constexpr double kScale = 1.07;
  const Vector2d off(0.25, -0.1);  // in the camera's axes
  std::vector<TimedPose> rough_path;
  for (const TimedPose& at : Path(1 / 30.0, 12)) {
    const Vector2d moved = at.pose * off;
    rough_path.push_back({at.stamp_s, {kScale * moved.x(), kScale * moved.y(), at.pose.yaw}});
  }
  std::vector<Pose2> rough;
  std::vector<Pose2> accurate;
  std::vector<ViewVelocity> velocities;
  const Pose2 T_other_first{1, 2, 0.5};  // the frame of the accurate poses is another one
  for (std::size_t i = 0; i < rough_path.size(); i += 6) {
    rough.push_back(rough_path[i].pose);
    velocities.push_back(VelocityAt(rough_path, i));
    accurate.push_back(T_other_first * CameraAt(rough_path[i].stamp_s));
  }
  const std::vector<ViewVelocity> refined = RefineVelocities(rough, velocities, accurate);
  ASSERT_EQ(refined.size(), rough.size());
  for (std::size_t i = 0; i < refined.size(); ++i) {
    ExpectVelocity(refined[i], rough_path[6 * i].stamp_s, 0.004);
  }
  EXPECT_GT((velocities[20].linear - refined[20].linear).norm(), 0.1);
}

TEST(ViewVelocities, AreZeroWhereTheRobotStands) {
  std::vector<Pose2> views{CameraAt(0), CameraAt(0.5), CameraAt(1)};
  const std::vector<ViewVelocity> refined =
      RefineVelocities(views, {{{0, 0}, 0}, {{0, 0.1}, 0.5}, {{0, 0}, 0}}, views);
  EXPECT_EQ(refined[0].yaw_rad_s, 0);
  EXPECT_EQ(refined[0].linear, Vector2d(0, 0));
  EXPECT_NEAR(refined[1].yaw_rad_s, 0.5, 0.01);
}

}  // namespace
}  // namespace ceilmap::mount
