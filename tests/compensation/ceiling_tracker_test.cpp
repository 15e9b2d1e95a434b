#include "compensation/ceiling_tracker.hpp"
#include "calib/base/degrees.hpp"

#include <gmock/gmock.h>

#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "calib/base/error.hpp"
#include "calib/level_view.hpp"
#include "tests/compensation/bumpy_drive.hpp"

namespace ceilmap::compensation {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
using synthetic::FrameAt;
using synthetic::FrontUp;

constexpr double kAxle = 0.14;

/// The camera beside the mast and turned in its mount: nothing that could be mixed up.
simulator::Scene OddLab() {
  simulator::Scene scene = synthetic::Lab();
  scene.camera.mount_x_m = 0.08;
  scene.camera.mount_y_m = -0.05;
  scene.camera.mount_yaw_deg = 25;
  return scene;
}

/// A robot that stands here and there, and a tracker that gets its images.
class Robot {
 public:
  explicit Robot(const simulator::Scene& scene = OddLab())
      : renderer_(scene),
        view_(*renderer_.GetRig().up, renderer_.GetRig().ceiling_height_m),
        tracker_(view_) {}

  CeilingTracker::Frame Observe(const Pose2& pose, const Tilt& tilt = {}) {
    truth_ = ToSpace(pose, tilt);
    return Show(renderer_.Render(FrameAt(index_, pose, tilt)));
  }
  CeilingTracker::Frame Show(const cv::Mat& image) {
    ++index_;
    return tracker_.Analyze(view_.Rectify(image, buffer_), 0.1 * static_cast<double>(index_));
  }
  std::optional<CeilingMotion> Measure(const Pose2& pose, const Tilt& tilt = {}) {
    CeilingTracker::Frame frame = Observe(pose, tilt);
    return tracker_.Measure(frame);
  }
  void StartAt(const Pose2& pose) {
    tracker_.SetReference(Observe(pose));
    T_map_reference_ = ToSpace(pose, {});
  }
  void ReferenceIs(const Pose2& pose) { T_map_reference_ = ToSpace(pose, {}); }

  /// Against where the robot stood last.
  void ExpectRight(const std::optional<CeilingMotion>& motion) const {
    ASSERT_TRUE(motion.has_value());
    const Isometry3d truth = T_map_reference_.inverse() * truth_;
    const PlanarTilt expected = FromSpace(truth);
    const PlanarTilt found = FromSpace(motion->T_reference_base);
    EXPECT_NEAR(found.tilt.pitch_rad, expected.tilt.pitch_rad, 0.08 * kRadPerDeg);
    EXPECT_NEAR(found.tilt.roll_rad, expected.tilt.roll_rad, 0.08 * kRadPerDeg);
    EXPECT_NEAR(found.tilt.lift_m, expected.tilt.lift_m, 0.002);
    EXPECT_NEAR((found.pose.Translation() - expected.pose.Translation()).norm(), 0, 0.004);
    EXPECT_NEAR(found.pose.yaw, expected.pose.yaw, 0.08 * kRadPerDeg);
    const Vector2d off(found.tilt.pitch_rad - expected.tilt.pitch_rad,
                       found.tilt.roll_rad - expected.tilt.roll_rad);
    EXPECT_LT(off.dot(motion->covariance.inverse() * off), 16);
    EXPECT_LT(std::sqrt(motion->covariance.trace()), 0.1 * kRadPerDeg);
    EXPECT_GE(motion->inliers, 10);
    EXPECT_LE(motion->inliers, motion->blocks);
  }

  CeilingTracker& Tracker() { return tracker_; }
  [[nodiscard]] const calib::CeilingView& View() const { return view_; }

 private:
  simulator::Renderer renderer_;
  calib::CeilingView view_;
  CeilingTracker tracker_;
  cv::Mat buffer_;
  std::int64_t index_ = 0;
  Isometry3d truth_ = Isometry3d::Identity();
  Isometry3d T_map_reference_ = Isometry3d::Identity();
};

TEST(CeilingTracker, MeasuresNothingWithoutAReference) {
  Robot robot;
  EXPECT_FALSE(robot.Tracker().HasReference());
  EXPECT_FALSE(robot.Measure({3, 3, 0}).has_value());
  robot.StartAt({3, 3, 0});
  EXPECT_TRUE(robot.Tracker().HasReference());
}

TEST(CeilingTracker, MeasuresARobotInSpace) {
  Robot robot;
  robot.StartAt({3, 2.5, 0.4});
  std::mt19937 random(9);
  const auto draw = [&](double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random);
  };
  for (int i = 0; i < 6; ++i) {
    SCOPED_TRACE(i);
    const Pose2 pose{3 + draw(0.2), 2.5 + draw(0.2), 0.4 + draw(0.1)};
    robot.ExpectRight(robot.Measure(pose, FrontUp(draw(4.6), kAxle, draw(3))));
  }
}

TEST(CeilingTracker, ALevelRobotIsLevel) {
  Robot robot;
  robot.StartAt({3, 2.5, 0});
  for (int i = 1; i <= 4; ++i) {
    const auto motion = robot.Measure({3 + 0.05 * i, 2.5, 0.02 * i});
    robot.ExpectRight(motion);
    const Tilt tilt = FromSpace(motion->T_reference_base).tilt;
    EXPECT_LT(std::hypot(tilt.pitch_rad, tilt.roll_rad), 0.03 * kRadPerDeg);
  }
}

// Were it not enlarged, there would be too few blocks.
TEST(CeilingTracker, ASmallImageIsSufficient) {
  simulator::Scene scene = OddLab();
  scene.camera.width_px = 240;
  scene.camera.height_px = 180;
  scene.camera.focal_px *= 0.75;
  Robot robot(scene);
  robot.StartAt({3, 2.5, 0});
  for (int i = 1; i <= 6; ++i) {
    SCOPED_TRACE(i);
    const auto motion = robot.Measure({3 + 0.06 * i, 2.5 + 0.03 * i, 0.04 * i});
    ASSERT_TRUE(motion.has_value());
    EXPECT_GE(motion->inliers, 20);
    const Tilt tilt = FromSpace(motion->T_reference_base).tilt;
    EXPECT_LT(std::hypot(tilt.pitch_rad, tilt.roll_rad), 0.15 * kRadPerDeg);
  }
}

// An image is 2.2 / 228.5 * 320 = 3.08 m by 2.31 m of ceiling.
TEST(CeilingTracker, OverlapIsThatOfALevelRobot) {
  Robot robot(synthetic::Lab());
  robot.StartAt({3, 2.5, 0});
  robot.Measure({3.1, 2.5, 0});
  const auto level = robot.Measure({3.2, 2.5, 0});
  ASSERT_TRUE(level.has_value());
  EXPECT_NEAR(level->overlap, 1 - 0.2 / 2.31, 0.005);
  const auto tilted = robot.Measure({3.2, 2.5, 0}, FrontUp(4, kAxle));
  ASSERT_TRUE(tilted.has_value());
  EXPECT_NEAR(tilted->overlap, level->overlap, 0.005);
}

// Faster than the prediction follows: the whole image is searched.
TEST(CeilingTracker, FindsAJump) {
  Robot robot;
  robot.StartAt({3, 2.5, 0});
  robot.ExpectRight(robot.Measure({3.02, 2.5, 0}));
  robot.ExpectRight(robot.Measure({3.5, 2.9, 0.5}, FrontUp(2, kAxle, 1)));
}

TEST(CeilingTracker, NoResultInTheDarkAndContinuesAfterIt) {
  Robot robot;
  robot.StartAt({3, 2.5, 0});
  robot.ExpectRight(robot.Measure({3.05, 2.5, 0}));
  CeilingTracker::Frame dark = robot.Show(cv::Mat(240, 320, CV_8UC1, cv::Scalar(2)));
  EXPECT_FALSE(robot.Tracker().Measure(dark).has_value());
  robot.ExpectRight(robot.Measure({3.15, 2.5, 0}, FrontUp(3, kAxle)));
}

TEST(CeilingTracker, NoResultForAnotherCeiling) {
  Robot robot;
  robot.StartAt({3, 2.5, 0});
  cv::Mat other(240, 320, CV_8UC1);
  cv::theRNG().state = 17;
  cv::randu(other, 0, 255);
  cv::GaussianBlur(other, other, {}, 3);
  cv::normalize(other, other, 20, 230, cv::NORM_MINMAX);
  CeilingTracker::Frame frame = robot.Show(other);
  EXPECT_FALSE(robot.Tracker().Measure(frame).has_value());
}

// A wheel that drops off within one frame: what was predicted is off by a dozen pixels, and the fit
// that begins there settles beside the truth.
TEST(CeilingTracker, FollowsADropWithinOneFrame) {
  for (const double deg : {-4.5, -4.0, -3.5, -3.0, 3.0, 4.0}) {
    SCOPED_TRACE(deg);
    Robot robot(synthetic::Lab());
    robot.StartAt({3, 2.5, 0});
    robot.ExpectRight(robot.Measure({3.1, 2.5, 0}, FrontUp(deg, kAxle)));
    robot.ExpectRight(robot.Measure({3.2, 2.5, 0}));
    robot.ExpectRight(robot.Measure({3.3, 2.5, 0}, FrontUp(-deg, kAxle)));
  }
}

TEST(CeilingTracker, GoesOnFromANewReference) {
  Robot robot;
  robot.StartAt({3, 2.5, 0.2});
  robot.ExpectRight(robot.Measure({3.1, 2.5, 0.2}));
  CeilingTracker::Frame next = robot.Observe({3.2, 2.5, 0.25});
  robot.ExpectRight(robot.Tracker().Measure(next));
  robot.ExpectRight(robot.Measure({3.3, 2.5, 0.3}, FrontUp(1, kAxle)));
  robot.Tracker().SetReference(next);  // an earlier one
  robot.ReferenceIs({3.2, 2.5, 0.25});
  robot.ExpectRight(robot.Measure({3.4, 2.5, 0.35}, FrontUp(2, kAxle)));
}

TEST(CeilingTracker, ATiltedFrameDrawnLevelIsAReference) {
  Robot robot;
  robot.StartAt({3, 2.5, 0.2});
  robot.ExpectRight(robot.Measure({3.1, 2.5, 0.2}));
  const Tilt tilt = FrontUp(4, kAxle, 1.5);
  CeilingTracker::Frame tilted = robot.Observe({3.2, 2.5, 0.25}, tilt);
  robot.ExpectRight(robot.Tracker().Measure(tilted));
  cv::Mat level;
  calib::LevelView(robot.View()).Draw(tilted.image.pixels, tilt, level);
  robot.Tracker().SetReference(tilted, level);
  robot.ReferenceIs({3.2, 2.5, 0.25});
  robot.ExpectRight(robot.Measure({3.3, 2.5, 0.3}, FrontUp(3, kAxle, 1)));
  robot.ExpectRight(robot.Measure({3.4, 2.5, 0.3}));
}

TEST(CeilingTracker, RefusesAViewInPixels) {
  const calib::CeilingView view = calib::CeilingView::InPixels({320, 240});
  EXPECT_THAT(
      [&] { CeilingTracker{view}; },
      testing::ThrowsMessage<InputError>("tilt cannot be seen on the ceiling without a rig"));
}

}  // namespace
}  // namespace ceilmap::compensation
