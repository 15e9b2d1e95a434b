#include "compensation/mount/motion_in_space.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/compensation/bumpy_drive.hpp"

namespace ceilmap::mount {
namespace {

using compensation::synthetic::FrameAt;
using Eigen::Isometry3d;

/// Feeds a path with a robot's images, and compares it with the true poses.
class Walk {
 public:
  explicit Walk(const simulator::Scene& scene, const std::vector<StampedTwist2>& known = {})
      : renderer_(scene),
        view_(*renderer_.GetRig().up, renderer_.GetRig().ceiling_height_m),
        motion_(view_, known) {}

  std::optional<Isometry3d> Show(const cv::Mat& image) {
    return motion_.Add(image, 0.1 * static_cast<double>(++shown_));
  }

  void Step(const simulator::Frame& frame) {
    if (shown_ == 0) T_map_first_ = frame.T_map_base;
    const auto found = Show(renderer_.Render(frame));
    ASSERT_TRUE(found) << "frame " << shown_;
    const Isometry3d off = (T_map_first_.inverse() * frame.T_map_base).inverse() * *found;
    max_off_m_ = std::max(max_off_m_, off.translation().norm());
    max_off_rad_ = std::max(max_off_rad_, Eigen::AngleAxisd(off.linear()).angle());
    last_ = *found;
  }

  [[nodiscard]] double MostOffM() const { return max_off_m_; }
  [[nodiscard]] double MostOffRad() const { return max_off_rad_; }
  [[nodiscard]] const Isometry3d& Last() const { return last_; }

  /// Ten images per second, of which each row has its own time.
  /// @param at  Pose at a time, s.
  template <typename PoseAt>
  void Drive(const PoseAt& at, int images, double half_s) {
    for (int i = 0; i <= images; ++i) {
      simulator::Frame frame = FrameAt(i, at(0.1 * i));
      frame.T_map_base_open = ToSpace(at(0.1 * i - half_s), {});
      frame.T_map_base_close = ToSpace(at(0.1 * i + half_s), {});
      Step(frame);
    }
  }

 private:
  simulator::Renderer renderer_;
  calib::CeilingView view_;
  MotionInSpace motion_;
  std::int64_t shown_ = 0;
  Isometry3d T_map_first_ = Isometry3d::Identity();
  Isometry3d last_ = Isometry3d::Identity();
  double max_off_m_ = 0;
  double max_off_rad_ = 0;
};

TEST(MotionInSpace, FollowsARobotOverBumps) {
  const simulator::Scene scene = compensation::synthetic::BumpyLab();
  Walk walk(scene);
  for (const simulator::Frame& frame : simulator::MakePath(scene)) walk.Step(frame);
  EXPECT_LT(walk.MostOffM(), 0.01);
  EXPECT_LT(walk.MostOffRad(), 0.15 * kRadPerDeg);
}

TEST(MotionInSpace, StaysUpOnAStep) {
  const simulator::Scene scene = compensation::synthetic::Lab();
  Walk walk(scene);
  constexpr double kStep = 0.02;
  for (int i = 0; i <= 24; ++i) {
    Tilt lift;
    lift.lift_m = kStep * std::clamp((i - 4) / 4.0, 0.0, 1.0);
    walk.Step(FrameAt(i, {2.4 + 0.08 * i, 2.8, 0.1}, lift));
  }
  // 1.9 m: some references further on.
  EXPECT_NEAR(walk.Last().translation().z(), kStep, 0.001);
  EXPECT_LT(walk.MostOffM(), 0.01);
}

TEST(MotionInSpace, TurnsOnTheSpot) {
  const simulator::Scene scene = compensation::synthetic::Lab();
  Walk walk(scene);
  for (int i = 0; i <= 24; ++i) walk.Step(FrameAt(i, {3, 3, WrapAngle(15 * kRadPerDeg * i)}));
  EXPECT_LT(walk.MostOffM(), 0.01);
  EXPECT_LT(walk.MostOffRad(), 0.15 * kRadPerDeg);
}

// The robot turns from the first image on.
TEST(MotionInSpace, TurnsWithARollingShutter) {
  simulator::Scene scene = compensation::synthetic::Lab();
  scene.camera.readout_time_s = 0.03;
  const auto at = [](double time_s) { return Pose2{3, 3, WrapAngle(0.8 * time_s)}; };
  Walk walk(scene);
  walk.Drive(at, 24, simulator::HalfExposure(scene.camera));
  EXPECT_LT(walk.MostOffM(), 0.01);
  EXPECT_LT(walk.MostOffRad(), 0.15 * kRadPerDeg);
}

// From rest to full speed between two images. Keyframes, of which the velocities are known, are
// farther apart.
TEST(MotionInSpace, StartsAbruptlyWithARollingShutter) {
  simulator::Scene scene = compensation::synthetic::Lab();
  scene.camera.readout_time_s = 0.03;
  constexpr double kStartS = 0.25;
  constexpr double kSpeed = 0.6;
  const auto at = [](double time_s) {
    return Pose2{2.4 + kSpeed * std::max(0.0, time_s - kStartS), 2.8, 0};
  };
  const Twist2 drives{{kSpeed, 0}, 0};
  Walk walk(scene, {{0.1, {}}, {0.3, {}}, {0.6, drives}, {1.7, drives}});  // stamps begin at 0.1
  walk.Drive(at, 16, simulator::HalfExposure(scene.camera));
  EXPECT_LT(walk.MostOffM(), 0.01);
  EXPECT_LT(walk.MostOffRad(), 0.15 * kRadPerDeg);
}

TEST(MotionInSpace, TellsNothingInTheDark) {
  const simulator::Scene scene = compensation::synthetic::Lab();
  Walk walk(scene);
  walk.Step(FrameAt(0, {3, 3, 0}));
  EXPECT_FALSE(
      walk.Show(cv::Mat(scene.camera.height_px, scene.camera.width_px, CV_8UC1, cv::Scalar(9))));
  walk.Step(FrameAt(2, {3.05, 3, 0}));
  EXPECT_LT(walk.MostOffM(), 0.01);
}

}  // namespace
}  // namespace ceilmap::mount
