#include <gmock/gmock.h>

#include <filesystem>

#include "calib/base/degrees.hpp"
#include "calib/ceiling_view.hpp"
#include "calib/rig_checks.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

TEST(RigYaml, ReadsBackAsTheScenesRobot) {
  Scene scene;
  scene.robot = "the \"second\" robot \\ 2";
  scene.axle_behind_mast_m = 0.14;
  scene.camera.distortion = {-0.21, 0.043, 0.0012, -0.0007, 0.001};
  scene.camera.mount_x_m = 0.02;
  scene.camera.mount_y_m = -0.01;
  scene.camera.mount_height_m = 0.52;
  const calib::Rig rig = calib::ParseRig(RigYaml(scene), "rig.yaml");
  EXPECT_EQ(rig.robot, scene.robot);
  EXPECT_EQ(rig.axle_behind_mast_m, 0.14);
  EXPECT_EQ(rig.ceiling_height_m, 2.6);
  EXPECT_FALSE(rig.forward_height_m.has_value());
  ASSERT_TRUE(rig.up.has_value());
  const calib::MountedCamera& up = rig.up.value();
  EXPECT_EQ(up.camera.distortion, scene.camera.distortion);
  EXPECT_EQ(up.camera.cx, 319.5);
  EXPECT_EQ(up.camera.cy, 239.5);
  EXPECT_EQ(up.camera.fy, 457.0);
  EXPECT_EQ(up.exposure_time_s, 0.005);
  EXPECT_EQ(up.T_base_cam.translation(), Eigen::Vector3d(0.02, -0.01, 0.52));
  // x_cam = +y_base, y_cam = -x_base, z_cam = +z_base.
  Eigen::Matrix3d R;
  R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  EXPECT_LT((up.T_base_cam.linear() - R).norm(), 1e-8);
}

TEST(RigYaml, ACameraThatIsNotLevelKeepsItsTilt) {
  Scene scene;
  scene.camera.mount_yaw_deg = 20;
  scene.camera.mount_pitch_deg = 3;
  scene.camera.mount_roll_deg = -2;
  const calib::Rig rig = calib::ParseRig(RigYaml(scene), "rig.yaml");
  const Eigen::Vector3d axis = rig.up->T_base_cam.linear().col(2);
  EXPECT_NEAR(axis.x(), std::sin(3 * kRadPerDeg), 1e-8);  // pitch about y tips the axis forward
  EXPECT_NEAR(axis.y(), std::sin(2 * kRadPerDeg) * std::cos(3 * kRadPerDeg), 1e-8);
  EXPECT_NO_THROW(calib::CeilingView(*rig.up, rig.ceiling_height_m));
}

TEST(RigYaml, ForwardCameraReadsBackAsTheScenes) {
  Scene scene;
  scene.forward = DefaultForwardCamera();
  scene.forward->mount_x_m = 0.03;
  scene.forward->distortion = {-0.1, 0.02, 0, 0, 0};
  const calib::Rig rig = calib::ParseRig(RigYaml(scene), "rig.yaml");
  EXPECT_EQ(rig.forward_height_m, 0.45);
  ASSERT_TRUE(rig.forward.has_value());
  const calib::MountedCamera& forward = rig.forward.value();
  EXPECT_EQ(forward.camera.Size(), cv::Size(640, 480));
  EXPECT_EQ(forward.camera.fx, 554.0);
  EXPECT_EQ(forward.camera.distortion, scene.forward->distortion);
  EXPECT_EQ(forward.exposure_time_s, 0.008);
  EXPECT_EQ(forward.T_base_cam.translation(), Eigen::Vector3d(0.03, 0, 0.45));
  // x_cam = -y_base, y_cam = -z_base, z_cam = +x_base.
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  EXPECT_LT((forward.T_base_cam.linear() - R).norm(), 1e-8);
  EXPECT_EQ(rig.up->camera.fx, 457.0);
}

TEST(RigYaml, ForwardCameraIsTurnedLeftThenRaisedThenRolled) {
  Scene scene;
  scene.forward = DefaultForwardCamera();
  scene.forward->mount_yaw_deg = 20;
  scene.forward->mount_pitch_deg = 14;
  scene.forward->mount_roll_deg = 5;
  const calib::Rig rig = calib::ParseRig(RigYaml(scene), "rig.yaml");
  const Eigen::Matrix3d R = rig.forward->T_base_cam.linear();
  EXPECT_NEAR(R(2, 2), std::sin(14 * kRadPerDeg), 1e-8);
  EXPECT_NEAR(std::atan2(R(1, 2), R(0, 2)), 20 * kRadPerDeg, 1e-8);
  EXPECT_NEAR(
      R(2, 0), -std::sin(5 * kRadPerDeg) * std::cos(14 * kRadPerDeg), 1e-8);  // right side down
}

TEST(RigYaml, RectifiedImageIsTheCeilingToScale) {
  // Position of a mark for the mapper, through the rig's distortion and mount.
  Scene scene = PlainScene();
  scene.camera.distortion = {-0.15, 0.02, 0, 0, 0};
  scene.camera.mount_x_m = 0.06;
  scene.ceiling.marks_at = {{6.2, 4.1, 0.05, 0.0}};
  const Renderer renderer(scene);
  const calib::CeilingView view(*renderer.GetRig().up, renderer.GetRig().ceiling_height_m);
  cv::Mat buffer;
  const cv::Mat& image = view.Rectify(renderer.Render(StillFrame(0, {6, 4, 0.3})), buffer);
  cv::Mat light;
  image.convertTo(light, CV_32F, 1 / 170.0);
  if (!view.Mask().empty()) light.setTo(1, view.Mask() == 0);
  const Eigen::Vector2d seen = CentreOfMark(light, 1.0);
  const Eigen::Vector2d p_view =
      view.MetresPerPixel() * (seen - Eigen::Vector2d((320 - 1) / 2.0, (240 - 1) / 2.0));
  const Eigen::Vector2d p_map = Pose2{6, 4, 0.3} * (view.T_base_view() * p_view);
  EXPECT_NEAR(p_map.x(), 6.2, 0.0005);
  EXPECT_NEAR(p_map.y(), 4.1, 0.0005);
}

TEST(RigYaml, RigsOfTheScenesHaveNoWarning) {
  const std::filesystem::path scenes =
      std::filesystem::path(CEILMAP_SOURCE_DIR) / "samples" / "scenes";
  for (const auto& entry : std::filesystem::directory_iterator(scenes)) {
    if (entry.path().extension() != ".yaml") continue;
    const calib::Rig rig = calib::ParseRig(RigYaml(ReadScene(entry.path())), entry.path());
    EXPECT_THAT(calib::RigWarnings(rig), ::testing::IsEmpty());
  }
}

}  // namespace
}  // namespace ceilmap::simulator
