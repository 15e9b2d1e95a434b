#include "mapping/registration/fine_stage.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "mapping/registration/noise.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

// Thresholds of the registration.
constexpr double kMinSupport = 4.2;
constexpr double kMinEvidence = 4.5;

using synthetic::AngleErrorDeg;
using synthetic::ShiftError;
using synthetic::SyntheticCeiling;

const cv::Size kFineSize(480, 360);

class FineStageTest : public testing::Test {
 protected:
  void Analyze(const cv::Mat& image, FrameSpectrum::Data& data) {
    data.noise = MakeNoise(EstimateNoise(image));
    fine_.Analyze(image, {}, data);
  }

  Hypothesis Near(const ImageMotion& truth, double off_px, double off_deg) {
    Hypothesis hypothesis;
    hypothesis.motion = truth;
    hypothesis.motion.tx_px += off_px;
    hypothesis.motion.ty_px -= 0.5 * off_px;
    hypothesis.motion.theta_rad += off_deg * kRadPerDeg;
    hypothesis.overlap = OverlapOf(truth, kFineSize);
    hypothesis.peak = 0.5;  // what the coarse stage finds on smeared images
    hypothesis.peak = 0.3;  // as the coarse stage finds it
    return hypothesis;
  }

  RegistrarParams params_;
  FineStage fine_{kFineSize, params_};
  SyntheticCeiling ceiling_;
  FrameSpectrum::Data reference_;
  FrameSpectrum::Data current_;
};

TEST_F(FineStageTest, BringsARoughMotionToTheLastDigit) {
  Analyze(ceiling_.Render(kFineSize), reference_);
  fine_.PrepareReference(reference_);
  for (const ImageMotion& truth : {ImageMotion{13.7, -41.2, 0.2, 1},
                                   ImageMotion{-60.3, 25.8, -2.1, 1},
                                   ImageMotion{0.25, 0.5, 3.1, 1}}) {
    Analyze(ceiling_.Render(kFineSize, truth), current_);
    for (const double off : {0.0, 4.0, -8.0}) {
      const Candidate candidate = fine_.Test(reference_, current_, Near(truth, off, 0.15 * off));
      EXPECT_GT(candidate.support, 2 * kMinSupport) << off;
      EXPECT_LT(ShiftError(candidate.motion, truth), 1) << off;
      const Finalist finalist = fine_.Refine(reference_, current_, candidate);
      ASSERT_TRUE(finalist.result.ok()) << off;
      EXPECT_LT(ShiftError(finalist.result.motion, truth), 0.01) << off;
      EXPECT_LT(AngleErrorDeg(finalist.result.motion, truth), 0.004) << off;
      // Images without noise count as encoded: their highest frequencies have less weight.
      EXPECT_GT(finalist.agreement, 0.75);
      EXPECT_GE(finalist.result.inliers, 0.9 * finalist.result.blocks);
    }
  }
}

TEST_F(FineStageTest, HoldsUnderBlurOfOneImage) {
  // A smear of 7 px turns the sign of the spectrum beyond 0.14 cycles per pixel.
  const ImageMotion truth{21.4, 8.3, 0.1, 1};
  Analyze(ceiling_.Render(kFineSize), reference_);
  fine_.PrepareReference(reference_);
  cv::Mat smeared;
  cv::blur(ceiling_.Render(kFineSize, truth), smeared, {7, 1});
  Analyze(smeared, current_);
  const Finalist finalist =
      fine_.Refine(reference_, current_, fine_.Test(reference_, current_, Near(truth, 3, 0.3)));
  ASSERT_TRUE(finalist.result.ok());
  EXPECT_LT(ShiftError(finalist.result.motion, truth), 0.1);
  EXPECT_LT(AngleErrorDeg(finalist.result.motion, truth), 0.05);
}

TEST_F(FineStageTest, AcceptsNoWrongHypothesis) {
  const ImageMotion truth{21.4, 8.3, 0.1, 1};
  Analyze(ceiling_.Render(kFineSize), reference_);
  Analyze(ceiling_.Render(kFineSize, truth), current_);
  fine_.PrepareReference(reference_);
  for (const ImageMotion& wrong :
       {ImageMotion{75, -30, 0.1, 1}, ImageMotion{21, 8, 0.9, 1}, ImageMotion{21, 8, -2.7, 1}}) {
    Hypothesis hypothesis;
    hypothesis.motion = wrong;
    const Finalist finalist =
        fine_.Refine(reference_, current_, fine_.Test(reference_, current_, hypothesis));
    EXPECT_EQ(finalist.result.verdict, Verdict::kNoMatch);
  }
}

TEST_F(FineStageTest, SeparatesTheTrueMotionFromOneByATile) {
  const SyntheticCeiling tiles({.tile_px = 60,
                                .tile_grey = 0,
                                .speckle_grey = 0,
                                .lamps = false,
                                .marks = false,
                                .own_marks = {{30, 40}}});
  const ImageMotion truth{11, 7, 0.02, 1};
  Analyze(tiles.Render(kFineSize), reference_);
  Analyze(tiles.Render(kFineSize, truth), current_);
  fine_.PrepareReference(reference_);
  const auto refine_near = [&](const ImageMotion& motion) {
    Finalist finalist =
        fine_.Refine(reference_, current_, fine_.Test(reference_, current_, Near(motion, 0, 0)));
    fine_.Compare(reference_, current_, finalist);
    return finalist;
  };
  const Finalist right = refine_near(truth);
  const Finalist wrong = refine_near(Compose(truth, ImageMotion{60, 0, 0, 1}));
  ASSERT_TRUE(right.result.ok());
  EXPECT_LT(ShiftError(right.result.motion, truth), 0.05);
  EXPECT_GT(Evidence(right.dissimilarity, wrong.dissimilarity), kMinEvidence);
  EXPECT_EQ(Evidence(wrong.dissimilarity, right.dissimilarity),
            -Evidence(right.dissimilarity, wrong.dissimilarity));
}

}  // namespace
}  // namespace ceilmap::registration
