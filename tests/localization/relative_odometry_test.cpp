#include "localization/relative_odometry.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "tests/localization/true_map.hpp"

namespace ceilmap::localization {
namespace {

using synthetic::Seen;
using synthetic::SyntheticCeiling;
using synthetic::UpCamera;

class RelativeOdometryTest : public testing::Test {
 protected:
  std::optional<ChainStep> Next(const Pose2& T, std::uint32_t seed = 1) {
    return Show(Seen(ceiling_, view_, T, seed));
  }
  std::optional<ChainStep> Show(const cv::Mat& image) {
    ++index_;
    return chain_.Next({{image, {}}, index_, 0.1 * static_cast<double>(index_)});
  }

  SyntheticCeiling ceiling_;
  calib::CeilingView view_{UpCamera(), synthetic::kCeiling_m};
  RelativeOdometry chain_{view_};
  std::int64_t index_ = 0;
};

TEST_F(RelativeOdometryTest, MeasuresTheMotionFromFrameToFrame) {
  Pose2 T{1, 2, 0.5};
  const Pose2 step{0.08, 0.01, 0.04};
  EXPECT_FALSE(Next(T));
  EXPECT_TRUE(chain_.Began());
  EXPECT_FALSE(chain_.Broken());            // nothing came before
  for (std::uint32_t i = 2; i < 25; ++i) {  // over several keyframes
    T = T * step;
    const auto measured = Next(T, i);
    ASSERT_TRUE(measured) << i;
    EXPECT_FALSE(chain_.Began());
    EXPECT_FALSE(measured->disambiguated_by_prior);
    const Pose2 off = step.Inverse() * measured->T_before_now;
    EXPECT_LT(off.Translation().norm(), 2e-3);
    EXPECT_LT(std::abs(off.yaw), 1e-3);
    EXPECT_LT(std::sqrt(measured->covariance(0, 0)), 5e-3);
    EXPECT_GT(measured->covariance(0, 0), 0);
  }
}

// A lens that fills a disc of the image: the rim moves with the camera, and is seen better than
// the plain ceiling.
TEST_F(RelativeOdometryTest, BlankBordersDoNotHoldTheRobot) {
  cv::Mat mask(view_.Size(), CV_8UC1, cv::Scalar(0));
  cv::circle(mask, {160, 120}, 110, cv::Scalar(255), cv::FILLED);
  const calib::CeilingView disc = calib::CeilingView::OfRectified(
      view_.Size(), view_.MetresPerPixel(), view_.T_base_view(), mask);
  const SyntheticCeiling plain({.tile_px = 0, .lamps = false, .marks = false});
  RelativeOdometry chain(disc);
  Pose2 T{1, 2, 0.5};
  const Pose2 step{0.1, 0.01, 0.04};
  for (int i = 0; i < 12; ++i, T = T * step) {
    cv::Mat image = Seen(plain, disc, T, static_cast<std::uint32_t>(i));
    image.setTo(0, mask == 0);
    const auto measured = chain.Next({{image, {}}, i, 0.1 * i});
    EXPECT_EQ(measured.has_value(), i > 0) << i;
    if (!measured) continue;
    const Pose2 off = step.Inverse() * measured->T_before_now;
    EXPECT_LT(off.Translation().norm(), 2e-3) << i;
    EXPECT_LT(std::abs(off.yaw), 1e-3) << i;
  }
}

TEST_F(RelativeOdometryTest, StepsReferToKeyframes) {
  const Pose2 step{0.08, 0.01, 0.04};
  Pose2 T{1, 2, 0.5};
  Pose2 T_keyframe = T;
  Pose2 T_before = T;
  EXPECT_FALSE(Next(T));
  int keyframes = 0;
  for (std::uint32_t i = 2; i < 25; ++i) {
    T = T * step;
    const auto measured = Next(T, i);
    ASSERT_TRUE(measured && measured->since_keyframe) << i;
    if (measured->since_keyframe->is_frame_before) {
      T_keyframe = T_before;
      ++keyframes;
    }
    const Pose2 off =
        (T_keyframe.Inverse() * T).Inverse() * measured->since_keyframe->T_keyframe_now;
    EXPECT_LT(off.Translation().norm(), 2e-3) << i;
    EXPECT_LT(std::abs(off.yaw), 1e-3) << i;
    T_before = T;
  }
  EXPECT_GT(keyframes, 1);
  EXPECT_LT(keyframes, 20);
}

TEST_F(RelativeOdometryTest, AJumpBreaksIt) {
  Next({0, 0, 0});
  ASSERT_TRUE(Next({0.05, 0, 0}));
  EXPECT_FALSE(Next({7, 9, 1}));
  EXPECT_TRUE(chain_.Broken());
  ASSERT_TRUE(Next({7.05, 9, 1}));
  EXPECT_FALSE(chain_.Broken());
}

TEST_F(RelativeOdometryTest, DarknessIsBridgedWhereTheRobotStayed) {
  const cv::Mat dark(view_.Size(), CV_8UC1, cv::Scalar(0));
  Next({0, 0, 0});
  ASSERT_TRUE(Next({0.05, 0, 0}));
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(Show(dark));
    EXPECT_FALSE(chain_.Broken());
    EXPECT_FALSE(chain_.Began());
  }
  const auto after = Next({0.15, 0.02, 0.1}, 9);
  ASSERT_TRUE(after);
  EXPECT_NEAR(after->T_before_now.x, 0.10, 3e-3);
  EXPECT_NEAR(after->T_before_now.y, 0.02, 3e-3);
}

TEST_F(RelativeOdometryTest, ResetForgets) {
  Next({0, 0, 0});
  chain_.Reset();
  EXPECT_FALSE(Next({0.05, 0, 0}));
  EXPECT_TRUE(chain_.Began());
  EXPECT_FALSE(chain_.Broken());
}

}  // namespace
}  // namespace ceilmap::localization
