#include "mapping/frame_prediction.hpp"

#include <gtest/gtest.h>

#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

/// A robot that drives and turns evenly: the same step from frame to frame.
class EvenMotionTest : public testing::Test {
 protected:
  EvenMotionTest() : step_{20 * view_.MetresPerPixel(), 0, 0.05} {
    for (int i = 0; i < 4; ++i) {
      prediction_.Begin(0.1 * i, {});
      if (i > 0) pose_ = pose_ * step_;
      prediction_.Placed(pose_);
    }
    prediction_.Begin(0.4, {});
  }

  [[nodiscard]] Pose2 After(double way, double turn) const {
    return pose_ * Pose2{way * step_.x, way * step_.y, turn * step_.yaw};
  }

  calib::CeilingView view_ = synthetic::SmallView();
  OdometryParams params_;
  FramePrediction prediction_{view_, {}, params_};
  Pose2 step_;
  Pose2 pose_;
};

TEST_F(EvenMotionTest, GoesOnEvenly) {
  EXPECT_FALSE(prediction_.IsUneven(After(1, 1)));
  EXPECT_FALSE(prediction_.FallsBehind(After(1, 1)));
}

TEST_F(EvenMotionTest, WayOrTurnThatEndsFallsBehind) {
  for (const Pose2& pose : {After(1, 0), After(0, 1)}) {
    EXPECT_TRUE(prediction_.IsUneven(pose)) << pose.x << ", " << pose.yaw;
    EXPECT_TRUE(prediction_.FallsBehind(pose)) << pose.x << ", " << pose.yaw;
  }
}

TEST_F(EvenMotionTest, ALargerStepIsUnevenButNotBehind) {
  for (const Pose2& pose : {After(1, 2), After(2, 1)}) {
    EXPECT_TRUE(prediction_.IsUneven(pose)) << pose.x << ", " << pose.yaw;
    EXPECT_FALSE(prediction_.FallsBehind(pose)) << pose.x << ", " << pose.yaw;
  }
}

TEST_F(EvenMotionTest, IsPredictedUntilAGap) {
  const std::optional<ExpectedPose> expected = prediction_.Next();
  ASSERT_TRUE(expected);
  EXPECT_NEAR(expected->T_map_base.x, After(1, 1).x, 1e-9);
  EXPECT_LT(expected->sigma_px, 20);
  // Four steps later it may be anywhere near, also one tile of a periodic ceiling further.
  prediction_.Begin(0.7, {});
  EXPECT_FALSE(prediction_.Next());
}

TEST_F(EvenMotionTest, AfterAGapACompassTellsTheTurnAlone) {
  FramePrediction prediction(view_, {}, params_);
  const auto heading = [](double yaw) { return HeadingPrior{yaw, 1e-4, HeadingFrame::kRelative}; };
  for (int i = 0; i < 3; ++i) {
    prediction.Begin(0.1 * i, heading(0));
    prediction.Placed({i * step_.x, 0, 0});
  }
  prediction.Begin(0.7, heading(0.3));
  const std::optional<ExpectedPose> expected = prediction.Next();
  ASSERT_TRUE(expected);
  EXPECT_NEAR(expected->T_map_base.yaw, 0.3, 1e-9);
  EXPECT_GT(expected->sigma_px, 20 * 5 * 0.9) << "the way of five steps";
}

TEST_F(EvenMotionTest, WithoutAStepBeforeNothingIsEven) {
  FramePrediction first(view_, {}, params_);
  first.Begin(0, {});
  EXPECT_TRUE(first.IsUneven({}));
  EXPECT_FALSE(first.FallsBehind({}));
}

}  // namespace
}  // namespace ceilmap::mapping
