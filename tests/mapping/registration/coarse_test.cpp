#include "mapping/registration/coarse.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mapping/registration/noise.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

using synthetic::AngleErrorDeg;
using synthetic::ShiftError;
using synthetic::SyntheticCeiling;

const cv::Size kImageSize(640, 480);

class CoarseStageTest : public testing::Test {
 protected:
  std::vector<Hypothesis> Propose(const ImageMotion& truth, bool estimate_scale = false) {
    Analyze(ceiling_.Render(kImageSize), reference_);
    Analyze(ceiling_.Render(kImageSize, truth), current_);
    return stage_.Propose(reference_, current_, estimate_scale);
  }

  void Analyze(const cv::Mat& image, FrameSpectrum::Coarse& data) {
    WorkingImage working;
    stage_.Reduce(image, {}, working);
    stage_.Analyze(working, MakeNoise(EstimateNoise(image)), data);
  }

  SyntheticCeiling ceiling_;
  CoarseStage stage_{kImageSize};
  FrameSpectrum::Coarse reference_;
  FrameSpectrum::Coarse current_;
};

TEST_F(CoarseStageTest, WorksOnHalfTheImage) {
  EXPECT_EQ(stage_.WorkingSize(), cv::Size(320, 240));
  EXPECT_EQ(CoarseStage({1283, 722}).WorkingSize(), cv::Size(320, 180));
  EXPECT_EQ(CoarseStage({200, 150}).WorkingSize(), cv::Size(200, 150));
}

TEST_F(CoarseStageTest, BestHypothesisIsNearTheTruth) {
  for (const ImageMotion& truth : {ImageMotion{0, 0, 0, 1},
                                   ImageMotion{37.3, -18.6, 0.3, 1},
                                   ImageMotion{0, 0, std::numbers::pi, 1},
                                   ImageMotion{-55.1, 24.9, std::numbers::pi - 0.02, 1},
                                   ImageMotion{81.5, 60.2, -2.4, 1},
                                   ImageMotion{-300, 10, 0, 1},
                                   ImageMotion{20, 235, std::numbers::pi, 1}}) {
    const auto hypotheses = Propose(truth);
    ASSERT_FALSE(hypotheses.empty());
    // Half a working pixel.
    EXPECT_LT(ShiftError(hypotheses[0].motion, truth), 1) << truth.tx_px << " " << truth.theta_rad;
    EXPECT_LT(AngleErrorDeg(hypotheses[0].motion, truth), 0.3);
    EXPECT_EQ(hypotheses[0].motion.scale, 1);
    EXPECT_GT(hypotheses[0].correlation, 0.6);
    for (std::size_t i = 1; i < hypotheses.size(); ++i) {
      EXPECT_LE(hypotheses[i].score, hypotheses[i - 1].score);
    }
  }
}

TEST_F(CoarseStageTest, WithScale) {
  for (const ImageMotion& truth :
       {ImageMotion{22, -31, 0.7, 1.3}, ImageMotion{-14, 5, std::numbers::pi, 0.75}}) {
    const auto hypotheses = Propose(truth, true);
    ASSERT_FALSE(hypotheses.empty());
    EXPECT_LT(ShiftError(hypotheses[0].motion, truth), 4);
    EXPECT_LT(AngleErrorDeg(hypotheses[0].motion, truth), 0.5);
    EXPECT_NEAR(hypotheses[0].motion.scale / truth.scale, 1, 0.02);
  }
}

TEST_F(CoarseStageTest, TriesOnlyRotationsInRange) {
  const ImageMotion truth{30, -20, 0.4, 1};
  Propose(truth);
  const auto expected = stage_.Propose(reference_, current_, false, RotationRange{0.35, 0.2});
  ASSERT_FALSE(expected.empty());
  EXPECT_LT(ShiftError(expected[0].motion, truth), 1);
  for (const double elsewhere : {0.4 + std::numbers::pi, 0.4 + std::numbers::pi / 2, -0.6}) {
    const RotationRange range{WrapAngle(elsewhere), 0.2};
    for (const Hypothesis& h : stage_.Propose(reference_, current_, false, range)) {
      EXPECT_LE(std::abs(WrapAngle(h.motion.theta_rad - elsewhere)), 0.21);
    }
  }
}

TEST_F(CoarseStageTest, TextureIsToldBeforeTheSpectraAndAfter) {
  const cv::Mat plain(kImageSize, CV_8UC1, cv::Scalar(120));
  for (const bool textured : {false, true}) {
    const cv::Mat image = textured ? ceiling_.Render(kImageSize) : plain;
    FrameSpectrum::Data data;
    data.noise = MakeNoise(EstimateNoise(image));
    stage_.Reduce(image, {}, data.working);
    EXPECT_EQ(stage_.ShowsTexture(data), textured);
    EXPECT_TRUE(data.coarse.spectrum.empty());
    EXPECT_EQ(stage_.Of(data).ShowsTexture(), textured);
    EXPECT_FALSE(data.coarse.spectrum.empty());
    EXPECT_EQ(stage_.ShowsTexture(data), textured);
  }
}

TEST_F(CoarseStageTest, ContrastIsThatOfTheTexture) {
  Analyze(cv::Mat(kImageSize, CV_8UC1, cv::Scalar(200)), reference_);
  EXPECT_LT(reference_.contrast, 0.01);
  // A shallow slope of brightness is no texture; a ceiling is.
  cv::Mat slope(kImageSize, CV_8UC1);
  for (int v = 0; v < kImageSize.height; ++v) slope.row(v).setTo(40 + 0.25 * v);
  Analyze(slope, reference_);
  EXPECT_LT(reference_.contrast, 3);
  Analyze(ceiling_.Render(kImageSize), reference_);
  EXPECT_GT(reference_.contrast, 8);
}

}  // namespace
}  // namespace ceilmap::registration
