// Odometry with a compass under ceilings of square tiles, which fit again after every quarter turn.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "mapping/odometry.hpp"
#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

using synthetic::CeilingParams;
using synthetic::MotionAt;
using synthetic::Periodic;
using synthetic::SyntheticCeiling;

constexpr double kQuarter = std::numbers::pi / 2;
constexpr int kTilePx = 60;

/// A compass that was read wrong by 0.7 rad when the drive began, and drifts.
struct Compass {
  bool on = true;
  double off = 0.7;                // now
  double drift_per_frame = 0.001;  // rad, to one side
  double variance = 1e-6;
};

class TurningDrive {
 public:
  explicit TurningDrive(const CeilingParams& ceiling,
                        bool compass,
                        const Pose2& start = {0.1, -0.2, 0.1})
      : ceiling_(ceiling), T_map_base_(start), odometry_(view_, start) {
    compass_.on = compass;
  }

  /// Moves by T_before_after, and processes the image there.
  const OdometryStep& Process(const Pose2& T_before_after = {}) {
    T_map_base_ = T_map_base_ * T_before_after;
    return ProcessImage(ceiling_.Render(
        view_.Size(), MotionAt(view_, T_map_base_), 1.5, static_cast<std::uint32_t>(Frame()) + 1));
  }
  const OdometryStep& SeeNothing(const Pose2& T_before_after = {}) {
    T_map_base_ = T_map_base_ * T_before_after;
    return ProcessImage(cv::Mat(view_.Size(), CV_8UC1, cv::Scalar(20)));
  }
  void Disturb(double off) { compass_.off += off; }
  void SwitchCompass(bool on) { compass_.on = on; }

  [[nodiscard]] const OdometryStep& Last() const { return steps_.back(); }
  [[nodiscard]] const std::vector<OdometryStep>& Steps() const { return steps_; }
  [[nodiscard]] double YawError() const {
    return std::abs(WrapAngle(Last().pose.T_map_base.yaw - T_map_base_.yaw));
  }
  [[nodiscard]] double Error() const {
    return (Last().pose.T_map_base.Translation() - T_map_base_.Translation()).norm();
  }
  [[nodiscard]] bool Right() const { return Error() < 0.01 && YawError() < 0.003; }

 private:
  [[nodiscard]] std::int64_t Frame() const { return static_cast<std::int64_t>(steps_.size()); }
  const OdometryStep& ProcessImage(const cv::Mat& image) {
    FrameContext context;
    if (compass_.on) {
      compass_.off += compass_.drift_per_frame;
      compass_.variance += compass_.drift_per_frame * compass_.drift_per_frame;
      context.heading = {WrapAngle(T_map_base_.yaw + compass_.off), compass_.variance};
    }
    steps_.push_back(
        odometry_.Process(image, Frame(), 0.1 * static_cast<double>(Frame()), context));
    return steps_.back();
  }

  SyntheticCeiling ceiling_;
  calib::CeilingView view_ = synthetic::SmallView();
  Pose2 T_map_base_;
  Compass compass_;
  Odometry odometry_;
  std::vector<OdometryStep> steps_;
};

/// A tile's corner with a mark: it identifies the tile, but not the quarter turn.
CeilingParams MarkedCorner() {
  CeilingParams params = Periodic(kTilePx);
  params.own_marks = {{0, 0}};
  return params;
}

void DriveAndTurnFast(TurningDrive& drive, double turn) {
  drive.Process();
  for (int i = 0; i < 6; ++i) drive.Process({0.08, 0, 0});
  for (int i = 0; i < 2; ++i) drive.Process({0, 0, turn / 2});
  for (int i = 0; i < 6; ++i) drive.Process({0.04, 0, 0});
}

TEST(OdometryWithCompass, FollowsAQuarterTurnWithinTwoFrames) {
  for (const double turn : {kQuarter, -kQuarter, 1.2 * kQuarter}) {
    TurningDrive drive(Periodic(kTilePx), true);
    DriveAndTurnFast(drive, turn);
    for (const OdometryStep& step : drive.Steps()) {
      EXPECT_EQ(step.pose.status, graph::TrackingStatus::kTracking) << step.pose.frame_index;
    }
    EXPECT_TRUE(drive.Right()) << drive.Error() << " m " << drive.YawError() << " rad";
  }
}

TEST(OdometryWithCompass, WithoutOneThePoseIsUnknownAfterSuchATurn) {
  TurningDrive drive(Periodic(kTilePx), false);
  DriveAndTurnFast(drive, kQuarter);
  int unknown = 0;
  for (const OdometryStep& step : drive.Steps()) {
    unknown += step.pose.status == graph::TrackingStatus::kAmbiguous ? 1 : 0;
  }
  EXPECT_GE(unknown, 4);
  EXPECT_FALSE(drive.Right());
}

TEST(OdometryWithCompass, IsCarriedThroughTheDark) {
  for (const bool compass : {true, false}) {
    TurningDrive drive(MarkedCorner(), compass);
    for (int i = 0; i < 3; ++i) drive.Process();
    for (int i = 0; i < 30; ++i) {
      EXPECT_EQ(drive.SeeNothing({0, 0, kQuarter / 30}).pose.status, graph::TrackingStatus::kLost);
    }
    drive.Process({0.03, 0.02, 0});
    EXPECT_EQ(drive.Last().pose.status,
              compass ? graph::TrackingStatus::kRelocalized : graph::TrackingStatus::kAmbiguous);
    EXPECT_TRUE(drive.Last().registration.disambiguated_by_prior)
        << "the ceiling alone is ambiguous";
    EXPECT_EQ(drive.Right(), compass) << drive.Error() << " m " << drive.YawError();
  }
}

TEST(OdometryWithCompass, DoesNotResolveTranslationsByATile) {
  TurningDrive drive(Periodic(kTilePx), true);
  for (int i = 0; i < 3; ++i) drive.Process();
  for (int i = 0; i < 30; ++i) drive.SeeNothing({0, 0, kQuarter / 30});
  for (int i = 1; i < OdometryParams().restart_after; ++i) {
    EXPECT_EQ(drive.Process({0.02, 0, 0}).pose.status, graph::TrackingStatus::kAmbiguous) << i;
  }
  const OdometryStep& anew = drive.Process({0.02, 0, 0});
  ASSERT_TRUE(anew.new_keyframe);
  EXPECT_TRUE(anew.new_edges.empty()) << "nothing ties it to the time before";
  EXPECT_LT(drive.YawError(), 0.05) << "but how it is turned is known";
}

TEST(OdometryWithCompass, ADisturbedOneIsHarmlessOnADistinctiveCeiling) {
  for (const double jump : {0.1, 0.5, kQuarter, 3.0}) {
    TurningDrive drive({}, true);
    drive.Process();
    for (int i = 0; i < 12; ++i) {
      if (i % 4 == 2) drive.Disturb(jump);
      EXPECT_EQ(drive.Process({0.08, 0, 0.02}).pose.status, graph::TrackingStatus::kTracking)
          << jump;
      EXPECT_TRUE(drive.Right()) << jump << " frame " << i;
    }
    for (int i = 0; i < 5; ++i) drive.SeeNothing();
    drive.Disturb(jump);
    EXPECT_EQ(drive.Process({0.08, 0, 0.02}).pose.status, graph::TrackingStatus::kTracking) << jump;
    EXPECT_TRUE(drive.Right()) << jump << " after the dark";
  }
}

TEST(OdometryWithCompass, ASmallDisturbanceDoesNotHurtUnderTilesEither) {
  for (const double jump : {0.05, -0.1, 0.2, -0.3}) {
    TurningDrive drive(Periodic(kTilePx), true);
    drive.Process();
    for (int i = 0; i < 12; ++i) {
      if (i % 4 == 2) drive.Disturb(jump);
      EXPECT_EQ(drive.Process({0.05, 0, 0.02}).pose.status, graph::TrackingStatus::kTracking)
          << jump;
    }
    EXPECT_TRUE(drive.Right()) << jump << ": " << drive.Error() << " m " << drive.YawError();
  }
}

TEST(OdometryWithCompass, FramesWithoutAHeadingMayLieBetween) {
  // The heading of the frame before the turn is missing: the turn counts from the one before that.
  TurningDrive drive(Periodic(kTilePx), true);
  drive.Process();
  for (int i = 0; i < 4; ++i) drive.Process({0.05, 0, 0.1});
  drive.SwitchCompass(false);
  drive.Process({0.05, 0, 0.1});
  drive.SwitchCompass(true);
  for (int i = 0; i < 2; ++i) drive.Process({0, 0, kQuarter / 2});
  EXPECT_EQ(drive.Last().pose.status, graph::TrackingStatus::kTracking);
  EXPECT_TRUE(drive.Right()) << drive.Error() << " m " << drive.YawError();
}

}  // namespace
}  // namespace ceilmap::mapping
