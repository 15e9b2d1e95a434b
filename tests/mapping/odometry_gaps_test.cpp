#include <gtest/gtest.h>

#include <string>

#include "mapping/odometry.hpp"
#include "tests/mapping/odometry_drive.hpp"

/// Frames that are missing without a trace, and images that repeat earlier ones.
namespace ceilmap::mapping {
namespace {

using calib::CeilingView;
using registration::synthetic::MotionAt;
using registration::synthetic::SyntheticCeiling;
using synthetic_drive::Drive;
using synthetic_drive::DriveEvenly;
using synthetic_drive::ExpectNear;
using synthetic_drive::MakeView;
using synthetic_drive::Placed;

// A recorder drops frames and numbers the others: their times tell nothing of it.
TEST(Odometry, FramesMayBeMissingWithoutATrace) {
  Drive drive;
  drive.Process();
  const auto drive_on = [&](int steps) {
    for (int i = 0; i < steps; ++i) drive.Move(0.12, 1);
    drive.Process();
  };
  for (int i = 0; i < 6; ++i) drive_on(1);
  for (const int steps : {2, 1, 3, 1, 1, 6, 1, 2, 2, 1}) drive_on(steps);
  for (std::size_t i = 0; i < drive.Steps().size(); ++i) {
    ASSERT_TRUE(Placed(drive.Steps()[i])) << i;
    ExpectNear(drive.Steps()[i].pose.T_map_base, drive.Truths()[i], "frame " + std::to_string(i));
  }
}

// Where the robot turned before, constant velocity leads elsewhere.
TEST(Odometry, FramesMayBeMissingWhereTheRobotDrivesOffAfterATurn) {
  Drive drive;
  DriveEvenly(drive);
  for (int i = 0; i < 6; ++i) {
    drive.Move(0, 8);
    ASSERT_TRUE(Placed(drive.Process())) << i;
  }
  drive.Move(0.2, 0);  // in four frames at the speed before the turn
  const OdometryStep after = drive.Process();
  ASSERT_TRUE(Placed(after));
  ExpectNear(after.pose.T_map_base, drive.Truth(), "after the missing frames");
}

// What a codec repeats says nothing about the motion.
TEST(Odometry, ARepeatedImageGivesNoPose) {
  const CeilingView view = MakeView();
  const SyntheticCeiling ceiling;
  Odometry odometry(view, {});
  const auto process = [&](int index, double repeated) {
    FrameContext context;
    context.repeated = repeated;
    const Pose2 truth{0.05 * index, 0, 0};
    return odometry.Process(
        ceiling.Render({640, 480}, MotionAt(view, truth), 1.5, 1), index, 0.1 * index, context);
  };
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(Placed(process(i, 0))) << i;
  EXPECT_EQ(process(5, 0.8).pose.status, graph::TrackingStatus::kAmbiguous);
  const OdometryStep after = process(6, 0.1);
  ASSERT_TRUE(Placed(after));
  ExpectNear(after.pose.T_map_base, {0.3, 0, 0}, "after the copy");
}

// A drive whose images have no noise of a sensor, as those of a codec.
class EncodedDrive {
 public:
  /// @param shown_x_m  Where the image was taken. @return the frame's step.
  OdometryStep Process(double shown_x_m, double pixel_rate_bit_s = 0) {
    return ProcessImage(ceiling_.Render({640, 480}, MotionAt(view_, {shown_x_m, 0, 0})),
                        {.encoding = {.pixel_rate_bit_s = pixel_rate_bit_s}});
  }
  OdometryStep SeeNothing() { return ProcessImage(cv::Mat::zeros(480, 640, CV_8UC1)); }
  /// The image before once more, bit by bit.
  OdometryStep SeeCopy() { return ProcessImage({}, {.repeated = 1}); }

 private:
  OdometryStep ProcessImage(const cv::Mat& image, const FrameContext& context = {}) {
    const int index = index_++;
    return odometry_.Process(image, index, 0.1 * index, context);
  }

  CeilingView view_ = MakeView();
  SyntheticCeiling ceiling_;
  Odometry odometry_{view_, {}};
  int index_ = 0;
};

TEST(Odometry, ACodecThatRepeatsAnImageDoesNotStopTheRobot) {
  EncodedDrive drive;
  double x_m = 0;
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(Placed(drive.Process(x_m += 0.05))) << i;
  EXPECT_FALSE(Placed(drive.Process(x_m))) << "the image before once more, at full speed";
  x_m += 0.05;
  for (int i = 0; i < 4; ++i) {
    const OdometryStep step = drive.Process(x_m += 0.05);
    ASSERT_TRUE(Placed(step)) << i;
    ExpectNear(step.pose.T_map_base, {x_m - 0.05, 0, 0}, "after the repeated image");
  }
}

TEST(Odometry, AnImageOnWhichTheCodecSpentNothingContinuesAMotionButFindsNoPlace) {
  constexpr double kStarved = 0.01;
  constexpr double kFed = 0.5;
  EncodedDrive drive;
  double x_m = 0;
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(Placed(drive.Process(x_m += 0.05, kStarved))) << i;
  EXPECT_FALSE(Placed(drive.SeeNothing()));
  EXPECT_FALSE(Placed(drive.Process(x_m += 0.1, kStarved)));
  const OdometryStep found = drive.Process(x_m += 0.05, kFed);
  ASSERT_TRUE(Placed(found));
  ExpectNear(found.pose.T_map_base, {x_m - 0.05, 0, 0}, "with bits again");
}

TEST(Odometry, AfterCopiesTheSameImageIsNoEvidenceOfAStandingRobot) {
  EncodedDrive drive;
  double x_m = 0.3;
  EXPECT_TRUE(Placed(drive.Process(x_m)));
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(Placed(drive.SeeCopy())) << i;
  EXPECT_FALSE(Placed(drive.Process(x_m)));
  x_m += 0.4;
  const OdometryStep found = drive.Process(x_m);
  ASSERT_TRUE(Placed(found));
  ExpectNear(found.pose.T_map_base, {0.4, 0, 0}, "where the ceiling moves on");
}

TEST(Odometry, ARobotThatBrakesAndStandsKeepsItsPoseInEncodedImages) {
  EncodedDrive drive;
  double x_m = 0;
  double step_m = 0.05;
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(Placed(drive.Process(x_m += step_m)));
  for (; step_m > 0; step_m -= 0.008) EXPECT_TRUE(Placed(drive.Process(x_m += step_m)));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(Placed(drive.Process(x_m))) << "standing, " << i;
}

}  // namespace
}  // namespace ceilmap::mapping
