// Odometry of a robot whose tilt is known: images that are drawn level, with blank borders.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "calib/base/degrees.hpp"
#include "calib/level_view.hpp"
#include "mapping/odometry.hpp"
#include "tests/compensation/bumpy_drive.hpp"

namespace ceilmap::mapping {
namespace {

using compensation::synthetic::BumpyLab;
using compensation::synthetic::FrameAt;
using compensation::synthetic::FrontUp;
using compensation::synthetic::Lab;

/// Rendered upward images of a drive.
class Recording {
 public:
  explicit Recording(const std::vector<simulator::Frame>& path, const simulator::Scene& scene)
      : path_(path),
        renderer_(scene),
        view_(*renderer_.GetRig().up, renderer_.GetRig().ceiling_height_m) {
    for (const simulator::Frame& frame : path_) images_.push_back(renderer_.Render(frame));
  }

  /// @param sigma_rad  Reported standard deviation of the tilts, which are exact.
  [[nodiscard]] std::vector<OdometryStep> Run(bool compensate = true, double sigma_rad = 0) const {
    const calib::LevelView level_view(view_);
    Odometry odometry(view_, TruthOf(0).pose);
    std::vector<OdometryStep> steps;
    for (std::size_t i = 0; i < path_.size(); ++i) {
      Tilt tilt;
      if (compensate) tilt = TruthOf(i).tilt;
      if (std::hypot(tilt.pitch_rad, tilt.roll_rad) < 1e-9) tilt = {};
      tilt.covariance = sigma_rad * sigma_rad * Eigen::Matrix2d::Identity();
      cv::Mat image = images_[i];
      if (!tilt.IsLevel()) level_view.Draw(images_[i], tilt, image = cv::Mat());
      steps.push_back(
          odometry.Process(image, static_cast<std::int64_t>(i), path_[i].stamp_s, {tilt, {}}));
    }
    return steps;
  }
  [[nodiscard]] PlanarTilt TruthOf(std::size_t i) const { return FromSpace(path_[i].T_map_base); }
  [[nodiscard]] double ErrorOf(const OdometryStep& step) const {
    const Pose2 truth = TruthOf(static_cast<std::size_t>(step.pose.frame_index)).pose;
    return (step.pose.T_map_base.Translation() - truth.Translation()).norm();
  }
  [[nodiscard]] const calib::CeilingView& View() const { return view_; }

 private:
  std::vector<simulator::Frame> path_;
  simulator::Renderer renderer_;
  calib::CeilingView view_;
  std::vector<cv::Mat> images_;
};

/// Over bumps in frames 12 to 19 and 26 to 33.
Recording OverBumps() {
  return Recording(simulator::MakePath(BumpyLab()), BumpyLab());
}

TEST(OdometryOfATiltedRobot, PlacesTheMastsFoot) {
  const Recording recording = OverBumps();
  for (const OdometryStep& step : recording.Run()) {
    ASSERT_EQ(step.pose.status, graph::TrackingStatus::kTracking) << step.pose.frame_index;
    EXPECT_LT(recording.ErrorOf(step), 0.004) << step.pose.frame_index;
    const Tilt truth = recording.TruthOf(static_cast<std::size_t>(step.pose.frame_index)).tilt;
    EXPECT_NEAR(step.pose.tilt.pitch_rad, truth.pitch_rad, 1e-9);
    EXPECT_NEAR(step.pose.tilt.roll_rad, truth.roll_rad, 1e-9);
  }
  double worst = 0;  // 4.5 degrees under a ceiling of 2.6 m
  for (const OdometryStep& step : recording.Run(false)) {
    worst = std::max(worst, recording.ErrorOf(step));
  }
  EXPECT_GT(worst, 0.17);
}

TEST(OdometryOfATiltedRobot, TheLastLevelFrameBecomesTheKeyframe) {
  // 0.3 m level, a bump, 0.4 m level, a bump; 0.23 m are a tenth of the image.
  std::vector<simulator::Frame> path;
  for (int i = 0; i < 22; ++i) {
    const bool tilted = (i >= 7 && i < 10) || i >= 19;
    path.push_back(
        FrameAt(i, {2.6 + 0.05 * i, 2.6, 0}, tilted ? FrontUp(2.5, 0.14, i - 8) : Tilt{}));
    path.back().stamp_s = 0.1 * i;
  }
  const Recording recording(path, Lab());
  const std::vector<OdometryStep> steps = recording.Run();
  int made = 0;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    if (!steps[i].new_keyframe) continue;
    EXPECT_TRUE(steps[i].new_keyframe->pose.tilt.IsLevel()) << i;
    const bool begins = !steps[i].pose.tilt.IsLevel() && steps[i - 1].pose.tilt.IsLevel();
    if (!begins) continue;
    ++made;
    EXPECT_EQ(steps[i].new_keyframe->pose.frame_index, static_cast<std::int64_t>(i) - 1);
    EXPECT_EQ(steps[i].pose.keyframe_id, steps[i].new_keyframe->id);
    EXPECT_EQ(cv::countNonZero(steps[i].new_keyframe->image), 320 * 240);
  }
  EXPECT_EQ(made, 2);
}

TEST(OdometryOfATiltedRobot, CovarianceHoldsWhatIsNotKnownOfTheTilt) {
  const Recording recording = OverBumps();
  constexpr double kSigma = 0.1 * kRadPerDeg;
  const std::vector<OdometryStep> accurate = recording.Run();
  const std::vector<OdometryStep> inaccurate = recording.Run(true, kSigma);
  const double sigma_m = 2.6 * kSigma;
  for (const std::size_t i : {14U, 16U, 18U}) {
    const Eigen::Matrix3d more = inaccurate[i].pose.covariance - accurate[i].pose.covariance;
    // The keyframe's own, and this frame's.
    EXPECT_GE(std::sqrt(more(0, 0)), 0.999 * sigma_m) << i;
    EXPECT_GE(std::sqrt(more(1, 1)), 0.999 * sigma_m) << i;
    EXPECT_LE(std::sqrt(more(0, 0)), 2 * sigma_m) << i;
    EXPECT_NEAR(
        inaccurate[i].tie.information.inverse()(0, 0) - accurate[i].tie.information.inverse()(0, 0),
        sigma_m * sigma_m,
        1e-3 * sigma_m * sigma_m);
  }
}

// Nothing but tilted frames: they become keyframes late, with blank borders that are 0.
TEST(OdometryOfATiltedRobot, ATiltedFrameBecomesAKeyframeWhenItMust) {
  std::vector<simulator::Frame> path;
  for (int i = 0; i <= 20; ++i) {
    path.push_back(FrameAt(i, {2.6 + 0.1 * i, 2.6, 0}, i == 0 ? Tilt{} : FrontUp(4, 0.14, 2)));
    path.back().stamp_s = 0.1 * i;
  }
  const Recording recording(path, Lab());
  int tilted = 0;
  double from_m = 0;
  for (const OdometryStep& step : recording.Run()) {
    ASSERT_EQ(step.pose.status, graph::TrackingStatus::kTracking) << step.pose.frame_index;
    EXPECT_LT(recording.ErrorOf(step), 0.006) << step.pose.frame_index;
    if (!step.new_keyframe || step.new_keyframe->pose.tilt.IsLevel()) continue;
    ++tilted;
    const double at_m = 0.1 * static_cast<double>(step.new_keyframe->pose.frame_index);
    EXPECT_GT(at_m - from_m, 0.95);  // half of 2.31 m, or the last frame that was seen well
    from_m = at_m;
    const cv::Mat& image = step.new_keyframe->image;
    EXPECT_LT(cv::countNonZero(image), 320 * 240 * 95 / 100);
    EXPECT_GT(cv::countNonZero(image), 320 * 240 * 85 / 100);
    EXPECT_EQ(cv::countNonZero(image(cv::Rect(60, 60, 200, 120))), 200 * 120);
  }
  EXPECT_GE(tilted, 1);
  EXPECT_LE(tilted, 2);
}

}  // namespace
}  // namespace ceilmap::mapping
