#include "mapping/frame_acceptance.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "tests/mapping/synthetic_drive.hpp"

namespace ceilmap::mapping {
namespace {

registration::RegistrarParams ParamsFor(const calib::CeilingView& view) {
  registration::RegistrarParams params;
  params.camera = registration::PlaneCameraOf(view);
  return params;
}

/// A frame after a loss, whose match with the last keyframe has the given peak.
class AfterALossTest : public testing::Test {
 protected:
  AfterALossTest()
      : registrar_(view_.Size(), ParamsFor(view_)), acceptance_(view_, prediction_, registrar_) {
    const cv::Mat image = synthetic::SyntheticCeiling({.seed = 3}).Render(view_.Size(), {}, 1, 1);
    keyframe_.spectrum = registrar_.Analyze(image);
    for (int i = 0; i < 5; ++i) acceptance_.Learn(keyframe_, keyframe_.spectrum, Match(kUsual));
    prediction_.Begin(0, {});
    prediction_.Placed({});
    prediction_.Begin(0.1, {});
    prediction_.Lost();
    prediction_.Begin(0.2, {});
  }

  [[nodiscard]] static registration::Registration Match(double peak) {
    registration::Registration match;
    match.verdict = registration::Verdict::kOk;
    match.peak = peak;
    match.blocks = 150;
    match.inliers = 60;
    return match;
  }
  bool Accepts(const registration::Registration& match) {
    FrameBefore before;
    before.T_map_placed = Pose2{};
    return acceptance_.StepsTo({keyframe_, keyframe_.spectrum, match, {}}, before).has_value();
  }

  static constexpr double kUsual = 0.5;
  calib::CeilingView view_ = synthetic::SmallView();
  OdometryParams params_;
  FramePrediction prediction_{view_, {}, params_};
  registration::Registrar registrar_;
  RecentKeyframe keyframe_;
  FrameAcceptance acceptance_;
};

// Heights explain the blocks of one thing under motions that are all wrong.
TEST_F(AfterALossTest, WithHeightsAMatchNeedsAPartOfTheUsualPeak) {
  registration::Registration poor = Match(0.15 * kUsual);
  EXPECT_TRUE(Accepts(poor));
  poor.heights = std::make_shared<const heights::HeightField>();
  EXPECT_FALSE(Accepts(poor));
  registration::Registration right = Match(0.55 * kUsual);
  right.heights = poor.heights;
  EXPECT_TRUE(Accepts(right));
}

}  // namespace
}  // namespace ceilmap::mapping
