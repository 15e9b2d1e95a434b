#include "mapping/frame_matching.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/mapping/depth_drive.hpp"

namespace ceilmap::mapping {
namespace {

using registration::synthetic::SyntheticDepth;

/// A keyframe at the origin, and a frame of the same camera.
class FrameMatching : public testing::Test {
 protected:
  RecentKeyframe KeyframeUnder(const SyntheticDepth& ceiling, double noise) {
    RecentKeyframe keyframe;
    keyframe.spectrum = registrar_.Analyze(synthetic::DepthImage(ceiling, view_, {}, 0, noise));
    return keyframe;
  }
  registration::Registration Match(const RecentKeyframe& keyframe,
                                   const SyntheticDepth& ceiling,
                                   const Pose2& truth,
                                   double noise) {
    const auto frame = registrar_.Analyze(synthetic::DepthImage(ceiling, view_, truth, 1, noise));
    return MatchFrame(view_, keyframe, frame, ExpectedPose{truth, 8, 0.02}, registrar_);
  }
  [[nodiscard]] registration::ImageMotion TrueMotion(const RecentKeyframe& keyframe,
                                                     const Pose2& truth) const {
    return PriorFor(view_, keyframe, {truth, 8, 0.02}).motion;
  }

  calib::CeilingView view_ = synthetic::CentredView();
  registration::Registrar registrar_{view_.Size(), synthetic::DepthParams(view_).registration};
};

// A fast robot, or few images a second: between two images the strips move up to 24 px further than
// the plane, and no height is known yet.
TEST_F(FrameMatching, FindsTheReferencePlaneBetweenImagesThatAreFarApart) {
  for (const double rho : {1.15, 1.35}) {
    const SyntheticDepth ceiling(rho);
    for (const double noise : {1.0, 3.0, 8.0}) {
      const RecentKeyframe keyframe = KeyframeUnder(ceiling, noise);
      for (const double way_m : {0.2, 0.35}) {
        const std::string which = std::to_string(rho) + ", noise " + std::to_string(noise) + ", " +
                                  std::to_string(way_m) + " m";
        const Pose2 truth{way_m, 0.02, 0};
        const registration::Registration found = Match(keyframe, ceiling, truth, noise);
        ASSERT_TRUE(found.ok()) << which;
        EXPECT_TRUE(found.heights) << which;
        const registration::ImageMotion expected = TrueMotion(keyframe, truth);
        EXPECT_LT(
            std::hypot(found.motion.tx_px - expected.tx_px, found.motion.ty_px - expected.ty_px),
            0.5)
            << which;  // of 40 and 70 px
        EXPECT_NEAR(found.motion.theta_rad, expected.theta_rad, 0.0015) << which;
      }
    }
  }
}

// No plane explains the images, so nothing is known of the scale of the frames before.
TEST_F(FrameMatching, FirstHeightsDoNotRescaleFramesThatNoPlanePlaced) {
  constexpr double kNoise = 5;
  const SyntheticDepth ceiling(1.35);
  const RecentKeyframe keyframe = KeyframeUnder(ceiling, kNoise);
  const registration::Registration found = Match(keyframe, ceiling, {0.2, 0.02, 0}, kNoise);
  ASSERT_TRUE(found.ok());
  ASSERT_TRUE(found.heights);
  EXPECT_EQ(found.rescaled, 1);
}

}  // namespace
}  // namespace ceilmap::mapping
