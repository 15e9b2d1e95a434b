#include "calib/rig.hpp"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "calib/camera_info.hpp"
#include "tests/calib/rig_text.hpp"

namespace ceilmap::calib {
namespace {

using ::testing::ElementsAre;

class RigFile : public ::testing::Test {
 protected:
  RigFile() { std::filesystem::create_directories(folder_); }
  ~RigFile() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path Write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) /
      ("ceilmap_rig_" +
       std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

TEST(Rig, ReadsTheRobot) {
  const Rig rig = ParseRig(kRigText, "rig.yaml");
  EXPECT_EQ(rig.robot, "robot 1");
  EXPECT_EQ(rig.axle_behind_mast_m, 0.14);
  EXPECT_EQ(rig.forward_height_m, 0.45);
  EXPECT_EQ(rig.ceiling_height_m, 2.6);
  EXPECT_EQ(rig.source_yaml, kRigText);
}

TEST(Rig, ReadsAPinholeCamera) {
  const Rig rig = ParseRig(kRigText, "rig.yaml");
  ASSERT_TRUE(rig.up);
  EXPECT_EQ(rig.up->camera.Size(), cv::Size(640, 480));
  EXPECT_EQ(rig.up->camera.Matrix(), cv::Matx33d(457, 0, 319.5, 0, 458, 239.5, 0, 0, 1));
  EXPECT_THAT(rig.up->camera.distortion, ElementsAre(-0.12, 0.02, 0.001, -0.002, 0.003, 0, 0, 0));
  EXPECT_EQ(rig.up->exposure_time_s, 0.005);
  EXPECT_FALSE(rig.up->mirror);
  // The image's right (x_cam) is the robot's left (+y), its bottom (y_cam) the robot's back (-x).
  const Eigen::Isometry3d& T_base_cam = rig.up->T_base_cam;
  EXPECT_TRUE((T_base_cam.linear() * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
  EXPECT_TRUE((T_base_cam.linear() * Eigen::Vector3d::UnitY()).isApprox(-Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(T_base_cam.translation().isApprox(Eigen::Vector3d(0.02, -0.01, 0.4), 1e-12));
}

TEST(Rig, ReadsAPoseFromAQuaternionAlone) {
  const Rig rig = ParseRig(kRigText, "rig.yaml");
  ASSERT_TRUE(rig.forward);
  EXPECT_FALSE(rig.forward->camera.IsDistorted());
  EXPECT_EQ(rig.forward->exposure_time_s, 0);
  // The optical axis is the robot's front, the image's right its right.
  const Eigen::Matrix3d R_base_cam = rig.forward->T_base_cam.linear();
  EXPECT_TRUE(R_base_cam.col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE(R_base_cam.col(0).isApprox(-Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_EQ(rig.forward->T_base_cam.translation().z(), 0.45);
}

TEST(Rig, ReadsWideLensesAndTheirView) {
  std::string text =
      Replaced(kRigText, "distortion_model: plumb_bob", "distortion_model: equidistant");
  text = Replaced(text,
                  "cols: 5, data: [-0.12, 0.02, 0.001, -0.002, 0.003]",
                  "cols: 4, data: [0.1, 0.2, 0.3, 0.4]");
  const Rig fisheye = ParseRig(text, "rig.yaml");
  EXPECT_EQ(fisheye.up->camera.model, LensModel::kEquidistant);
  EXPECT_THAT(fisheye.up->camera.Coefficients(), ElementsAre(0.1, 0.2, 0.3, 0.4));
  EXPECT_FALSE(fisheye.up->view);
  text = Replaced(text,
                  "    exposure_time",
                  "    view: {field_of_view_deg: 90, size: [600, 400]}\n    exposure_time");
  const Rig chosen = ParseRig(text, "rig.yaml");
  ASSERT_TRUE(chosen.up->view);
  EXPECT_NEAR(chosen.up->view->field_of_view_rad.value(), std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(chosen.up->view->size, cv::Size(600, 400));
  EXPECT_FALSE(ParseRig(Replaced(text, "field_of_view_deg: 90, ", ""), "rig.yaml")
                   .up->view->field_of_view_rad);
}

TEST(Rig, ReadsTheReadoutTimeOfARollingShutter) {
  EXPECT_EQ(ParseRig(kRigText, "rig.yaml").up->readout_time_s, 0);
  const std::string rolling =
      Replaced(kRigText, "    exposure_time", "    readout_time_s: -0.02\n    exposure_time");
  EXPECT_EQ(ParseRig(rolling, "rig.yaml").up->readout_time_s, -0.02);
}

TEST(Rig, ReadsAMirror) {
  const Rig rig = ParseRig(kRigText, "rig.yaml");
  ASSERT_TRUE(rig.omni && rig.omni->mirror);
  const HyperbolicMirror& mirror = *rig.omni->mirror;
  EXPECT_EQ(mirror.A_m, 0.028095);
  EXPECT_EQ(mirror.B_m, 0.0234125);
  EXPECT_EQ(mirror.C_m, 0.0365714941);
  EXPECT_EQ(mirror.rim_radius_m, 0.04);
  EXPECT_EQ(mirror.rim_radius_px, 225.623);
  EXPECT_EQ(mirror.horizon_radius_px, 138.707);
  EXPECT_EQ(rig.omni->T_base_cam.translation().z(), 0.55);
}

// Of an uncalibrated camera the size of its images, the ring and the pose are enough.
TEST(Rig, ReadsAMirrorOfUnknownShape) {
  const std::string mirror = kRigText.substr(kRigText.find("    mirror:\n"));
  std::string text =
      Replaced(kRigText, mirror, "    mirror: {inner_radius_px: 60, outer_radius_px: 225}\n");
  text = Replaced(text, "type: hyperbolic_mirror", "type: mirror");
  const Rig calibrated = ParseRig(text, "rig.yaml");
  ASSERT_TRUE(calibrated.omni && calibrated.omni->mirror_ring);
  EXPECT_FALSE(calibrated.omni->mirror);
  EXPECT_EQ(calibrated.omni->mirror_ring->centre_px, Eigen::Vector2d(239.5, 239.5));
  EXPECT_EQ(calibrated.omni->mirror_ring->inner_radius_px, 60);
  EXPECT_EQ(calibrated.omni->mirror_ring->outer_radius_px, 225);

  const std::size_t begin = text.rfind("    camera_matrix");
  text.erase(begin, text.rfind("    base_link_to_camera") - begin);
  text = Replaced(text, "outer_radius_px: 225", "outer_radius_px: 225, centre_px: [238, 241]");
  const Rig plain = ParseRig(text, "rig.yaml");
  ASSERT_TRUE(plain.omni && plain.omni->mirror_ring);
  EXPECT_EQ(plain.omni->camera.Size(), cv::Size(480, 480));
  EXPECT_EQ(plain.omni->camera.fx, 0);
  EXPECT_EQ(plain.omni->mirror_ring->centre_px, Eigen::Vector2d(238, 241));
}

TEST(Rig, TakesNullAsAbsentForwardHeight) {
  for (const char* line : {"d: null\n", "d: ~\n", "d:\n", ""}) {
    EXPECT_FALSE(ParseRig(Replaced(kRigText, "d: 0.45\n", line), "rig.yaml").forward_height_m);
  }
}

TEST(Rig, TakesAnAxleAheadOfTheMast) {
  EXPECT_EQ(ParseRig(Replaced(kRigText, "a: 0.14", "a: -0.2"), "r").axle_behind_mast_m, -0.2);
}

// The rig of calib/README.md, "Defaults".
TEST(Rig, EightLinesAreEnough) {
  const Rig rig = ParseRig(kMinimalRigText, "rig.yaml");
  ASSERT_TRUE(rig.up);
  EXPECT_EQ(rig.axle_behind_mast_m, 0);
  EXPECT_FALSE(rig.up->camera.IsDistorted());
  EXPECT_EQ(rig.up->exposure_time_s, 0);
  EXPECT_EQ(rig.up->T_base_cam.translation(), Eigen::Vector3d(0, 0, 0.4));
  // The image's right (x_cam) is the robot's left (+y), its bottom (y_cam) the robot's back (-x).
  const Eigen::Matrix3d& R_base_cam = rig.up->T_base_cam.linear();
  EXPECT_EQ(R_base_cam.col(0), Eigen::Vector3d::UnitY());
  EXPECT_EQ(R_base_cam.col(1), -Eigen::Vector3d::UnitX());
  EXPECT_EQ(R_base_cam.col(2), Eigen::Vector3d::UnitZ());
  EXPECT_THAT(
      rig.assumed,
      ElementsAre(
          "a = 0: the axle of the driven wheels is below the camera mast",
          "cameras.up: it looks straight up, the top of its image is towards the robot's front",
          "cameras.up: a lens without distortion"));
  EXPECT_THAT(ParseRig(kRigText, "rig.yaml").assumed, ElementsAre());
}

/// The YAML block of a README after a text.
std::string BlockOf(const char* readme, const std::string& after) {
  std::ifstream stream(std::filesystem::path(CEILMAP_SOURCE_DIR) / readme);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const std::string begin = "```yaml\n";
  const std::size_t at = text.find(begin, text.find(after)) + begin.size();
  return text.substr(at, text.find("```", at) - at);
}

TEST(Rig, TheReadmesShowIt) {
  EXPECT_EQ(BlockOf("calib/README.md", "### Defaults"), kMinimalRigText);
  const std::string shown = BlockOf("README.md", "The shortest `rig.yaml`");
  EXPECT_EQ(std::count(shown.begin(), shown.end(), '\n'), 8);
  const Rig rig = ParseRig(shown, "README.md");
  EXPECT_EQ(rig.up->camera.Matrix(), ParseRig(kMinimalRigText, "r").up->camera.Matrix());
  EXPECT_EQ(rig.up->T_base_cam.translation().z(), 0.4);
  EXPECT_EQ(rig.ceiling_height_m, 2.6);
}

TEST(Rig, AForwardCameraLooksAheadUnlessItsRotationIsGiven) {
  const Rig rig =
      ParseRig(Replaced(kRigText, "      rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]\n", ""), "rig.yaml");
  const Eigen::Matrix3d& R_base_cam = rig.forward->T_base_cam.linear();
  EXPECT_EQ(R_base_cam.col(0), -Eigen::Vector3d::UnitY());
  EXPECT_EQ(R_base_cam.col(1), -Eigen::Vector3d::UnitZ());
  EXPECT_EQ(R_base_cam.col(2), Eigen::Vector3d::UnitX());
  EXPECT_THAT(rig.assumed,
              ElementsAre("cameras.forward: it looks straight ahead, level, the top of its image "
                          "is up"));
}

TEST(Rig, MakesRoundedRotationsOrthonormal) {
  std::string text = Replaced(kRigText, "rotation_xyzw: [0, 0, 0.707106781, 0.707106781]\n", "\n");
  text =
      Replaced(text, "[0, -1, 0, 0.02, 1, 0, 0, -0.01,", "[0, -1.0004, 0, 0.02, 1, 0, 0, -0.01,");
  const Eigen::Matrix3d R = ParseRig(text, "rig.yaml").up->T_base_cam.linear();
  EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST_F(RigFile, ReadsIntrinsicsFromACameraInfoFileBesideIt) {
  const std::string info = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [430.15, 0.0, 311.2, 0.0, 430.6, 236.9, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.33, 0.11, -0.0004, 0.0002, 0]
)";
  Write("up.yaml", info);
  const std::size_t begin = kRigText.find("    image_width: 640");
  const std::size_t end = kRigText.find("    base_link_to_camera");
  std::string text = kRigText;
  text.replace(begin, end - begin, "    camera_info: up.yaml\n");
  const Rig rig = ReadRig(Write("rig.yaml", text));
  EXPECT_EQ(rig.up->camera.Matrix(), cv::Matx33d(430.15, 0, 311.2, 0, 430.6, 236.9, 0, 0, 1));
  EXPECT_THAT(rig.up->camera.distortion, ElementsAre(-0.33, 0.11, -0.0004, 0.0002, 0, 0, 0, 0));
  EXPECT_EQ(ReadCameraInfo(folder_ / "up.yaml").fy, 430.6);
}

TEST(Rig, ReadsTheRigsOfTheSamples) {
  int count = 0;
  const std::filesystem::path samples = std::filesystem::path(CEILMAP_SOURCE_DIR) / "samples";
  for (const auto& entry : std::filesystem::directory_iterator(samples)) {
    if (!std::filesystem::exists(entry.path() / "rig.yaml")) continue;
    const Rig rig = ReadRig(entry.path() / "rig.yaml");
    EXPECT_TRUE(rig.up || rig.forward || rig.omni) << entry.path();
    ++count;
  }
  if (count == 0) GTEST_SKIP() << "no samples in this tree";
}

}  // namespace
}  // namespace ceilmap::calib
