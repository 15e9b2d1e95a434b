#include "calib/level_view.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

#include "calib/base/error.hpp"
#include "compensation/tilt_model.hpp"
#include "samples/simulator/renderer.hpp"

namespace ceilmap::calib {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kCeiling = 2.6;

Tilt MakeTilt(double pitch_rad, double roll_rad, double lift_m) {
  return {pitch_rad, roll_rad, lift_m, Eigen::Matrix2d::Zero()};
}

/// Upwards, 0.4 m up the mast, its front at the image's top.
MountedCamera UpCamera() {
  MountedCamera up;
  up.camera = {320, 240, 220, 220, 159.5, 119.5, {}};
  up.T_base_cam.linear() = AngleAxisd(kPi / 2, Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Vector3d(0, 0, 0.4);
  return up;
}

/// Beside the mast, turned, its principal point off the centre: nothing that could be mixed up.
MountedCamera OddCamera() {
  MountedCamera up = UpCamera();
  up.camera.cx = 150;
  up.camera.cy = 128;
  up.T_base_cam.linear() = AngleAxisd(70 * kRadPerDeg, Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Vector3d(0.12, -0.07, 0.4);
  return up;
}

double Draw(std::mt19937& random, double limit) {
  return std::uniform_real_distribution<double>(-limit, limit)(random);
}

Tilt RandomTilt(std::mt19937& random) {
  return MakeTilt(
      Draw(random, 10 * kRadPerDeg), Draw(random, 10 * kRadPerDeg), 0.02 + Draw(random, 0.02));
}

// Matsumoto et al.: a = 14 cm, h = 260 cm. The mast's foot stands a sin(tilt) above the floor.
TEST(LevelView, CeilingShiftIsEq2AndEq3) {
  const LevelView view(CeilingView(UpCamera(), kCeiling));
  constexpr double kAxle = 0.14;
  const compensation::TiltModel front_climbs(-kAxle, kCeiling);
  const compensation::TiltModel rear_climbs(kAxle, kCeiling);
  for (const double deg : {1.99, 3.76, 4.64, 8.0}) {
    const double tilt = deg * kRadPerDeg;
    const double lift = kAxle * std::sin(tilt);
    const double expected = rear_climbs.CeilingShift(tilt);
    EXPECT_NEAR(front_climbs.CeilingShift(-tilt), -expected, 1e-15);
    const Vector2d nose_down = view.CeilingShift(MakeTilt(tilt, 0, lift));
    EXPECT_NEAR((nose_down - Vector2d(expected, 0)).norm(), 0, 1e-12);
    const Vector2d nose_up = view.CeilingShift(MakeTilt(-tilt, 0, lift));
    EXPECT_NEAR((nose_up + Vector2d(expected, 0)).norm(), 0, 1e-12);
    // Left side up: the mast's axis meets the ceiling to the right.
    const Vector2d left_up = view.CeilingShift(MakeTilt(0, tilt, lift));
    EXPECT_NEAR((left_up + Vector2d(0, expected)).norm(), 0, 1e-12);
  }
  const double deg = 4.64;
  EXPECT_NEAR(
      view.CeilingShift(MakeTilt(deg * kRadPerDeg, 0, kAxle * std::sin(deg * kRadPerDeg))).x(),
      0.21,
      5e-4);
}

TEST(LevelView, CeilingShiftOfAnyCameraIsWhereItsAxisMeetsTheCeiling) {
  const CeilingView ceiling(OddCamera(), kCeiling);
  const LevelView view(ceiling);
  std::mt19937 random(3);
  for (int i = 0; i < 50; ++i) {
    const Tilt tilt = RandomTilt(random);
    const Isometry3d T = ToSpace({}, tilt) * OddCamera().T_base_cam;
    const Vector3d axis = T.linear() * Vector3d::UnitZ();
    const Vector3d met = T.translation() + (kCeiling - T.translation().z()) / axis.z() * axis;
    EXPECT_NEAR(
        (view.CeilingShift(tilt) - (met.head<2>() - Vector2d(0.12, -0.07))).norm(), 0, 1e-12);
  }
}

// A level robot at the uncompensated pose has the same point of the ceiling.
TEST(LevelView, UncompensatedIsThePoseThatALevelRobotWouldNeed) {
  const LevelView view(CeilingView(OddCamera(), kCeiling));
  std::mt19937 random(4);
  for (int i = 0; i < 50; ++i) {
    const Tilt tilt = RandomTilt(random);
    const Pose2 pose{Draw(random, 5), Draw(random, 5), Draw(random, kPi)};
    const Isometry3d T = ToSpace(pose, tilt) * OddCamera().T_base_cam;
    const Vector3d axis = T.linear() * Vector3d::UnitZ();
    const Vector3d met = T.translation() + (kCeiling - T.translation().z()) / axis.z() * axis;
    const Pose2 seen = view.Uncompensated(pose, tilt);
    EXPECT_NEAR((seen * Vector2d(0.12, -0.07) - met.head<2>()).norm(), 0, 1e-12);
    EXPECT_NEAR(WrapAngle(seen.yaw - pose.yaw), 0, 1e-12);
  }
  const Pose2 level = view.Uncompensated({1, 2, 3}, {});
  EXPECT_EQ(level.Translation(), Vector2d(1, 2));
  EXPECT_EQ(level.yaw, 3);
}

// Points of the ceiling seen by the robot level and tilted, by the raw camera's own model.
TEST(LevelView, TiltedFromLevelIsWhatPointsOfTheCeilingDo) {
  const MountedCamera up = OddCamera();
  const LevelView view(CeilingView(up, kCeiling));
  std::mt19937 random(5);
  for (int i = 0; i < 500; ++i) {
    const Tilt tilt = RandomTilt(random);
    const Pose2 pose{Draw(random, 5), Draw(random, 5), Draw(random, kPi)};
    const Vector3d p_map(pose.x + Draw(random, 1.5), pose.y + Draw(random, 1.5), kCeiling);
    const auto level = up.camera.Project((ToSpace(pose, {}) * up.T_base_cam).inverse() * p_map);
    const auto tilted = up.camera.Project((ToSpace(pose, tilt) * up.T_base_cam).inverse() * p_map);
    ASSERT_TRUE(level && tilted);
    const Vector2d found = (view.TiltedFromLevel(tilt) * level->homogeneous()).hnormalized();
    EXPECT_NEAR((found - *tilted).norm(), 0, 1e-9);
  }
}

TEST(LevelView, RefusesAViewWithoutARig) {
  const char* const message =
      "a tilt can only be taken out of images of a camera whose rig is known";
  EXPECT_THAT(
      [] {
        LevelView{CeilingView::InPixels({320, 240})};
      },
      testing::ThrowsMessage<InputError>(message));
  EXPECT_THAT(
      [] {
        LevelView{CeilingView::OfRectified({320, 240}, 0.01, {})};
      },
      testing::ThrowsMessage<InputError>(message));
}

/// A ceiling of tiles, seen without noise or shading, by a camera beside the mast.
simulator::Scene ClearScene() {
  simulator::Scene scene;
  scene.camera = {320, 240, 220};
  scene.camera.mount_x_m = 0.1;
  scene.camera.mount_y_m = -0.06;
  scene.camera.mount_yaw_deg = -12;
  scene.ceiling.lamp_every_x = scene.ceiling.lamp_every_y = 4;
  scene.image.motion_blur = false;
  scene.image.blur_px = 0.9;
  scene.image.glare = scene.image.vignetting = 0;
  scene.image.shot_noise = scene.image.read_noise = scene.image.gain_spread = 0;
  return scene;
}

simulator::Frame FrameAt(const Pose2& pose, const Tilt& tilt) {
  simulator::Frame frame = simulator::StillFrame(0, pose);
  frame.T_map_base = ToSpace(pose, tilt);
  frame.T_map_base_open = frame.T_map_base_close = frame.T_map_base;
  return frame;
}

/// Whether the level image is blank at the pixels that the tilted one does not show, and nowhere
/// else; in between, where rounding decides, it may be either.
void ExpectBlankWhereNothingWasSeen(const LevelView& view,
                                    const cv::Mat& mask,
                                    const Tilt& tilt,
                                    const cv::Mat& level) {
  const Eigen::Matrix3d map = view.TiltedFromLevel(tilt);
  int blank = 0;
  int wrong = 0;
  for (int v = 0; v < level.rows; ++v) {
    for (int u = 0; u < level.cols; ++u) {
      const Vector2d at = (map * Vector3d(u, v, 1)).hnormalized();
      const auto seen = [&](double margin) {
        if (at.x() < margin || at.x() > level.cols - 1 - margin) return false;
        if (at.y() < margin || at.y() > level.rows - 1 - margin) return false;
        if (mask.empty()) return true;
        const cv::Rect four(static_cast<int>(at.x()), static_cast<int>(at.y()), 2, 2);
        const cv::Rect inside(0, 0, level.cols, level.rows);
        return cv::countNonZero(mask(four & inside)) == (four & inside).area();
      };
      const bool is_blank = level.at<std::uint8_t>(v, u) == 0;
      blank += is_blank ? 1 : 0;
      if (is_blank && seen(0.001)) ++wrong;
      if (!is_blank && !seen(-0.001)) ++wrong;
    }
  }
  EXPECT_GT(blank, 500);
  EXPECT_EQ(wrong, 0);
}

/// Compares a tilted image drawn level with what the level robot would have seen.
void ExpectLevelImage(const simulator::Scene& scene, const Tilt& tilt) {
  const simulator::Renderer renderer(scene);
  const CeilingView ceiling(*renderer.GetRig().up, renderer.GetRig().ceiling_height_m);
  const LevelView view(ceiling);
  const Pose2 pose{5.3, 4.2, 0.7};
  cv::Mat level_buffer;
  cv::Mat tilted_buffer;
  const cv::Mat expected = ceiling.Rectify(renderer.Render(FrameAt(pose, {})), level_buffer);
  const cv::Mat tilted = ceiling.Rectify(renderer.Render(FrameAt(pose, tilt)), tilted_buffer);
  cv::Mat level;
  view.Draw(tilted, tilt, level);
  ExpectBlankWhereNothingWasSeen(view, ceiling.Mask(), tilt, level);
  cv::Mat both = level > 0;
  if (!ceiling.Mask().empty()) both &= ceiling.Mask();
  cv::Mat difference;
  cv::absdiff(level, expected, difference);
  difference.setTo(0, ~both);
  const int compared = cv::countNonZero(both);
  EXPECT_GT(compared, 320 * 240 / 2);
  EXPECT_LT(cv::sum(difference)[0] / compared, 0.6);
  EXPECT_LT(cv::countNonZero(difference > 6), compared / 200);
  // Without the lift, or with a sign turned, it would not fit.
  for (const Tilt& other : {MakeTilt(tilt.pitch_rad, tilt.roll_rad, 0),
                            MakeTilt(tilt.pitch_rad, -tilt.roll_rad, tilt.lift_m)}) {
    view.Draw(tilted, other, level);
    cv::absdiff(level, expected, difference);
    difference.setTo(0, ~both);
    EXPECT_GT(cv::sum(difference)[0] / compared, 1.2);
  }
}

TEST(LevelView, DrawsTheImageOfALevelRobot) {
  ExpectLevelImage(ClearScene(), MakeTilt(4.6 * kRadPerDeg, -2.5 * kRadPerDeg, 0.03));
  ExpectLevelImage(ClearScene(), MakeTilt(-3.3 * kRadPerDeg, 2 * kRadPerDeg, 0.02));
}

TEST(LevelView, MasksTheBlankPixelsOfARectifiedImage) {
  simulator::Scene scene = ClearScene();
  scene.camera.mount_pitch_deg = 3;
  scene.camera.mount_roll_deg = -4;
  ASSERT_FALSE(CeilingView(*simulator::Renderer(scene).GetRig().up, 2.6).Mask().empty());
  ExpectLevelImage(scene, MakeTilt(3 * kRadPerDeg, 3 * kRadPerDeg, 0.03));
}

// A level robot's image stays as it is to its borders, and so does that of one whose tilt moves
// nothing by more than rounding.
TEST(LevelView, DrawsTheImageToItsLastRowAndColumn) {
  const LevelView view(CeilingView(UpCamera(), kCeiling));
  cv::Mat image(240, 320, CV_8UC1);
  cv::RNG(3).fill(image, cv::RNG::UNIFORM, 1, 256);
  cv::Mat level;
  for (const double tilt_rad : {0.0, 1e-7, -1e-7}) {
    view.Draw(image, MakeTilt(tilt_rad, tilt_rad, 0), level);
    EXPECT_EQ(cv::countNonZero(level), 320 * 240) << tilt_rad;
    EXPECT_LE(cv::norm(level, image, cv::NORM_INF), tilt_rad == 0 ? 0 : 1) << tilt_rad;
  }
}

// Black is content, and drawn as 1: only what was not seen is 0. The image shifts by 10.4 px.
TEST(LevelView, BlackIsNotBlank) {
  const LevelView view(CeilingView(UpCamera(), kCeiling));
  const cv::Mat black(240, 320, CV_8UC1, cv::Scalar(0));
  cv::Mat level;
  view.Draw(black, MakeTilt(2.7 * kRadPerDeg, 0, 0), level);
  EXPECT_EQ(cv::countNonZero(level(cv::Rect(20, 20, 280, 200)) != 1), 0);
  EXPECT_LT(cv::countNonZero(level), 320 * 233);
  const cv::Mat white(240, 320, CV_8UC1, cv::Scalar(255));
  view.Draw(white, MakeTilt(2.7 * kRadPerDeg, 0, 0), level);
  EXPECT_EQ(cv::countNonZero(level(cv::Rect(20, 20, 280, 200)) != 255), 0);
}

TEST(ContentMask, IsEmptyWhereAImageIsFull) {
  cv::Mat level(60, 80, CV_8UC1, cv::Scalar(9));
  EXPECT_TRUE(ContentMask(level).empty());
  // Black pixels, alone, in a line and in a corner of content.
  level.at<std::uint8_t>(30, 40) = 0;
  level.row(20).colRange(10, 70).setTo(0);
  level(cv::Rect(50, 40, 4, 4)).setTo(0);
  EXPECT_TRUE(ContentMask(level).empty());
}

TEST(ContentMask, LeavesOutBordersHoweverThin) {
  cv::Mat level(60, 80, CV_8UC1, cv::Scalar(9));
  level.colRange(0, 7).setTo(0);
  level.row(59).setTo(0);
  level.at<std::uint8_t>(30, 40) = 0;
  const cv::Mat mask = ContentMask(level);
  ASSERT_EQ(mask.size(), level.size());
  ASSERT_EQ(mask.type(), CV_8UC1);
  EXPECT_EQ(cv::countNonZero(mask.colRange(0, 7)), 0);
  EXPECT_EQ(cv::countNonZero(mask.row(59)), 0);
  EXPECT_EQ(cv::countNonZero(mask == 255), 59 * 73);
}

}  // namespace
}  // namespace ceilmap::calib
