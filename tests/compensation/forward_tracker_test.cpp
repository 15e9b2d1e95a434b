#include "compensation/forward_tracker.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tests/compensation/bumpy_drive.hpp"

namespace ceilmap::compensation {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using synthetic::FrameAt;
using synthetic::FrontUp;

constexpr double kAxle = 0.14;
constexpr double kWall_m = 8;
const Pose2 kStart{4.5, 3, 0};

/// Nothing but a wall full of images, straight ahead, and a floor that shows nothing.
simulator::Scene WallScene() {
  simulator::Scene scene = synthetic::Lab();
  scene.fixtures.boxes.clear();
  scene.fixtures.ducts_per_100m2 = scene.fixtures.sprinklers_per_100m2 = 0;
  scene.room.wall_posters_per_100m2 = 150;
  scene.room.height_m = 4;
  scene.room.floor_contrast = 0;
  return scene;
}

/// A robot before a wall, and a tracker that gets its images.
class Robot {
 public:
  explicit Robot(const simulator::Scene& scene = WallScene())
      : renderer_(scene), view_(*renderer_.GetRig().forward), tracker_(view_) {}

  [[nodiscard]] cv::Mat Image(const Pose2& pose, const Tilt& tilt = {}) const {
    return renderer_.RenderForward(FrameAt(index_ + 1, pose, tilt));
  }
  ForwardTracker::Frame Show(const cv::Mat& image) {
    ++index_;
    return tracker_.Analyze(view_.Rectify(image, buffer_), 0.1 * static_cast<double>(index_));
  }
  std::optional<ForwardMotion> Measure(const cv::Mat& image) {
    ForwardTracker::Frame frame = Show(image);
    return tracker_.Measure(frame);
  }
  std::optional<ForwardMotion> Measure(const Pose2& pose, const Tilt& tilt = {}) {
    return Measure(Image(pose, tilt));
  }
  void StartAt(const Pose2& pose) {
    tracker_.SetReference(Show(Image(pose)));
    reference_ = pose;
  }
  void ReferenceIs(const Pose2& pose) { reference_ = pose; }

  /// By the geometry of a level axis that meets the wall.
  void ExpectRight(const std::optional<ForwardMotion>& motion,
                   const Pose2& pose,
                   const Tilt& tilt = {},
                   double roll_bound_rad = 0.1 * kRadPerDeg) const {
    ASSERT_TRUE(motion.has_value());
    const Vector3d mount = renderer_.GetRig().forward->T_base_cam.translation();
    const Isometry3d T = ToSpace(pose, tilt);
    const Vector3d camera = T * mount;
    const Vector3d keyframe = ToSpace(reference_, {}) * mount;
    const Vector3d axis = T.linear() * Vector3d::UnitX();
    const double ahead_m = kWall_m - camera.x();
    const Vector3d met = camera + ahead_m / axis.x() * axis - keyframe;
    EXPECT_NEAR(motion->tan_shift, -met.z() / met.x(), 0.7 / view_.FocalLength());
    EXPECT_NEAR(motion->zoom, ahead_m / (kWall_m - keyframe.x()), 0.006);
    EXPECT_NEAR(motion->roll_rad, tilt.roll_rad, roll_bound_rad);
    EXPECT_LT(motion->sigma_tan_shift, 1.2 / view_.FocalLength());
    EXPECT_LT(motion->sigma_zoom, 0.01);
    EXPECT_LT(motion->sigma_roll_rad, 0.1 * kRadPerDeg);
    EXPECT_LE(motion->inliers, motion->blocks);
  }

  ForwardTracker& Tracker() { return tracker_; }
  [[nodiscard]] const calib::ForwardView& View() const { return view_; }

 private:
  simulator::Renderer renderer_;
  calib::ForwardView view_;
  ForwardTracker tracker_;
  cv::Mat buffer_;
  std::int64_t index_ = 0;
  Pose2 reference_;
};

TEST(ForwardTracker, MeasuresNothingWithoutAReference) {
  Robot robot;
  EXPECT_FALSE(robot.Tracker().HasReference());
  EXPECT_FALSE(robot.Measure(kStart).has_value());
  robot.StartAt(kStart);
  EXPECT_TRUE(robot.Tracker().HasReference());
}

TEST(ForwardTracker, NoseUpAndLeftSideUp) {
  Robot robot;
  robot.StartAt(kStart);
  for (const Tilt& tilt : {Tilt{},
                           FrontUp(1, kAxle),
                           FrontUp(2.5, kAxle),
                           FrontUp(4, kAxle),
                           FrontUp(2, kAxle, 2),
                           FrontUp(0, kAxle, -2)}) {
    const auto motion = robot.Measure(kStart, tilt);
    robot.ExpectRight(motion, kStart, tilt);
    // Signs, independent of the geometry above.
    if (tilt.pitch_rad < -0.5 * kRadPerDeg) {
      EXPECT_LT(motion->tan_shift, -0.01);
    }
    if (tilt.roll_rad > 0) {
      EXPECT_GT(motion->roll_rad, 0.03);
    }
  }
}

TEST(ForwardTracker, ZoomIsAboveOneBehindTheKeyframe) {
  Robot robot;
  robot.StartAt({4.9, 3, 0});
  for (const double x_m : {4.7, 4.8, 4.9, 5.0, 5.1}) {
    SCOPED_TRACE(x_m);
    const Pose2 pose{x_m, 3, 0};
    robot.ExpectRight(robot.Measure(pose, FrontUp(2, kAxle)), pose, FrontUp(2, kAxle));
  }
}

TEST(ForwardTracker, GoesOnFromANewReference) {
  Robot robot;
  robot.StartAt(kStart);
  const Pose2 next{4.6, 3, 0};
  ForwardTracker::Frame frame = robot.Show(robot.Image(next));
  robot.ExpectRight(robot.Tracker().Measure(frame), next);
  const Pose2 last{4.7, 3, 0};
  robot.ExpectRight(robot.Measure(last, FrontUp(1, kAxle)), last, FrontUp(1, kAxle));
  robot.Tracker().SetReference(frame);
  robot.ReferenceIs(next);
  robot.ExpectRight(robot.Measure({4.8, 3, 0}, FrontUp(2, kAxle)), {4.8, 3, 0}, FrontUp(2, kAxle));
}

TEST(ForwardTracker, NoResultInTheDarkAndContinuesAfterIt) {
  Robot robot;
  robot.StartAt(kStart);
  EXPECT_TRUE(robot.Measure(kStart, FrontUp(1, kAxle)).has_value());
  for (const int grey : {0, 3, 255}) {
    EXPECT_FALSE(robot.Measure(cv::Mat(240, 320, CV_8UC1, cv::Scalar(grey))).has_value());
  }
  robot.ExpectRight(robot.Measure(kStart, FrontUp(2, kAxle)), kStart, FrontUp(2, kAxle));
}

// A half that lies to one side shows the key-stone of the pitch as a roll.
TEST(ForwardTracker, HalfCoveredIsSufficient) {
  Robot robot;
  robot.StartAt(kStart);
  for (int i = 1; i <= 3; ++i) {
    cv::Mat image = robot.Image(kStart, FrontUp(i, kAxle));
    image.colRange(0, 150).setTo(0);
    robot.ExpectRight(robot.Measure(image), kStart, FrontUp(i, kAxle), 0.4 * kRadPerDeg);
  }
}

TEST(ForwardTracker, SomethingThatMovesDropsOut) {
  Robot robot;
  robot.StartAt(kStart);
  for (int i = 0; i < 5; ++i) {
    SCOPED_TRACE(i);
    cv::Mat image = robot.Image(kStart, FrontUp(0.7 * i, kAxle));
    cv::rectangle(image, cv::Rect(40 + 25 * i, 60, 70, 150), cv::Scalar(220), cv::FILLED);
    cv::rectangle(image, cv::Rect(55 + 25 * i, 90, 30, 60), cv::Scalar(30), cv::FILLED);
    robot.ExpectRight(robot.Measure(image), kStart, FrontUp(0.7 * i, kAxle), 0.2 * kRadPerDeg);
  }
}

// What it shows is not the keyframe's place: no tilt at all rather than a wrong one.
TEST(ForwardTracker, NoResultForAnotherPlace) {
  Robot robot;
  robot.StartAt(kStart);
  EXPECT_FALSE(robot.Measure(Pose2{4, 3, 2}).has_value());
}

}  // namespace
}  // namespace ceilmap::compensation
