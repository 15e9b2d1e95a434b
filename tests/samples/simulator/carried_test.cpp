#include <gmock/gmock.h>

#include <cmath>

#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "samples/simulator/gyro.hpp"
#include "samples/simulator/path.hpp"
#include "samples/simulator/wheels.hpp"

namespace ceilmap::simulator {
namespace {

Scene CarriedScene() {
  Scene scene;
  scene.path.kind = PathKind::kWaypoints;
  scene.path.waypoints_m = {{2, 2}, {6, 2}};
  scene.path.carried = {{3, 9, 3, 90}, {5, 4, 6, 0}};
  scene.camera.exposure_time_s = 0.02;
  return scene;
}

TEST(Carried, ThePathGoesOnFromTheNewPose) {
  Scene scene = CarriedScene();
  const std::vector<Frame> carried = MakePath(scene);
  scene.path.carried.clear();
  const std::vector<Frame> path = MakePath(scene);
  ASSERT_EQ(carried.size(), path.size());
  EXPECT_EQ(carried[29].T_map_base.matrix(), path[29].T_map_base.matrix());
  // Frame 30 is at 3 s, when it is put down with its front to +y.
  EXPECT_LT((carried[30].T_map_base.translation() - Eigen::Vector3d(9, 3, 0)).norm(), 1e-9);
  const double driven = path[40].T_map_base(0, 3) - path[30].T_map_base(0, 3);
  EXPECT_GT(driven, 0.5);
  EXPECT_LT((carried[40].T_map_base.translation() - Eigen::Vector3d(9, 3 + driven, 0)).norm(),
            1e-9);
  EXPECT_NEAR(carried[40].T_map_base(1, 0), 1, 1e-9);
  EXPECT_LT((carried[50].T_map_base.translation() - Eigen::Vector3d(4, 6, 0)).norm(), 1e-9);
}

TEST(Carried, ExposuresAreNotSmeared) {
  const std::vector<Frame> frames = MakePath(CarriedScene());
  for (const Frame& frame : frames) {
    const double moved =
        (frame.T_map_base_close.translation() - frame.T_map_base_open.translation()).norm();
    EXPECT_LT(moved, 0.8 * 0.02 + 1e-9);
  }
}

TEST(Carried, WheelsAndGyroShowNothing) {
  Scene scene = CarriedScene();
  scene.wheels.emplace();
  scene.gyro.emplace();
  const std::vector<WheelSample> wheels = MakeWheels(scene, 106);
  const std::vector<GyroSample> gyro = MakeGyro(scene, 106);
  scene.path.carried.clear();
  EXPECT_EQ(wheels.back().T_odom_base.x, MakeWheels(scene, 106).back().T_odom_base.x);
  for (const GyroSample& sample : gyro) EXPECT_NEAR(sample.omega_z_rad_s, 0, 1e-12);
}

TEST(Carried, AFilesPosesToo) {
  Scene scene = CarriedScene();
  scene.path.kind = PathKind::kTum;
  scene.path.tum_file = "drive.tum";
  for (int i = 0; i < 70; ++i) {
    PathPose pose{i * 0.1, Eigen::Isometry3d::Identity()};
    pose.T_map_base.translation() = Eigen::Vector3d(2 + 0.05 * i, 2, 0.01);
    scene.path.poses.push_back(pose);
  }
  const std::vector<Frame> frames = MakePath(scene);
  EXPECT_LT((frames[32].T_map_base.translation() - Eigen::Vector3d(9, 3.1, 0.01)).norm(), 1e-6);
}

TEST(Carried, MustStayInTheRoom) {
  Scene scene = CarriedScene();
  scene.path.carried = {{3, 9, 7.9, 90}};
  try {
    (void)MakePath(scene);
    ADD_FAILURE() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("path.carried: at 103."));
    EXPECT_THAT(error.what(), testing::HasSubstr("must be inside of the room of 12 x 8 x 2.6 m"));
  }
}

}  // namespace
}  // namespace ceilmap::simulator
