// Motions that are there: how exactly they are found, under noise, blur and other light.

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "calib/base/error.hpp"
#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

TEST_F(RegistrarTest, RandomMotionsOverTheFullCircle) {
  std::mt19937 random(1);
  for (std::uint32_t i = 0; i < 24; ++i) {
    const SyntheticCeiling ceiling({.seed = i, .tile_px = i % 3 == 0 ? 0.0 : 90.0 + i});
    const ImageMotion truth = RandomMotion(random, false, 0.5);
    const Registration r = Register(ceiling.Render(kSize), ceiling.Render(kSize, truth));
    EXPECT_THAT(r, IsMotion(truth, 0.02, 0.02)) << i;
    EXPECT_EQ(r.motion.scale, 1);
    EXPECT_GT(r.peak, 0.6);
    EXPECT_LE(r.peak, 1);
    EXPECT_LT(r.runner_up, r.peak);
  }
}

TEST_F(RegistrarTest, ASpectrumIsThatOfAnyRegistrarOfItsSize) {
  const SyntheticCeiling ceiling;
  const cv::Mat image = ceiling.Render(kSize);
  const cv::Mat other = ceiling.Render(kSize, {30, -12, 0.3, 1});
  Registrar first(kSize);
  Registrar second(kSize);
  const Registration shared = second.Register(first.Analyze(image), second.Analyze(other));
  const Registration own = first.Register(first.Analyze(image), first.Analyze(other));
  ASSERT_TRUE(shared.ok());
  EXPECT_EQ(shared.motion.tx_px, own.motion.tx_px);
  EXPECT_EQ(shared.motion.ty_px, own.motion.ty_px);
  EXPECT_EQ(shared.motion.theta_rad, own.motion.theta_rad);
  EXPECT_EQ(shared.covariance, own.covariance);
}

TEST_F(RegistrarTest, AnAnalysedImageKeepsItsOwnCopyOfTheMask) {
  const SyntheticCeiling ceiling;
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, kSize.width / 3, kSize.height)) = 0;
  const ImageMotion truth{30, -12, 0.3, 1};
  cv::Mat reference = ceiling.Render(kSize);
  reference.setTo(0, mask == 0);
  const FrameSpectrum before = registrar_.Analyze(reference, mask);
  const FrameSpectrum same = registrar_.Analyze(reference, mask.clone());
  mask = 255;
  const FrameSpectrum current = registrar_.Analyze(ceiling.Render(kSize, truth));
  const Registration r = registrar_.Register(before, current);
  EXPECT_THAT(r, IsMotion(truth, 0.03, 0.02));
  EXPECT_EQ(r.covariance, registrar_.Register(same, current).covariance);
}

TEST_F(RegistrarTest, NearASharpPriorTheMotionIsAsExact) {
  std::mt19937 random(3);
  for (std::uint32_t i = 0; i < 12; ++i) {
    const SyntheticCeiling ceiling({.seed = i});
    const ImageMotion truth = RandomMotion(random, false, 0.5);
    MotionPrior prior{truth, 4, 0.15};
    prior.motion.tx_px += 5;
    prior.motion.ty_px -= 4;
    prior.motion.theta_rad += 0.02;
    const FrameSpectrum a = registrar_.Analyze(ceiling.Render(kSize, {}, 2, i));
    const FrameSpectrum b = registrar_.Analyze(ceiling.Render(kSize, truth, 2, i + 500));
    const Registration near = registrar_.Register(a, b, prior);
    EXPECT_THAT(near, IsMotion(truth, 0.05, 0.03)) << i;
    EXPECT_FALSE(near.disambiguated_by_prior);
  }
}

TEST_F(RegistrarTest, AWrongSharpPriorDoesNotMislead) {
  std::mt19937 random(4);
  for (std::uint32_t i = 0; i < 12; ++i) {
    const SyntheticCeiling ceiling({.seed = i, .tile_px = i % 2 == 0 ? 0.0 : 90.0});
    const ImageMotion truth = RandomMotion(random, false, 0.6);
    MotionPrior prior{truth, 4, 0.15};
    prior.motion.tx_px += 90;
    const Registration r = registrar_.Register(registrar_.Analyze(ceiling.Render(kSize)),
                                               registrar_.Analyze(ceiling.Render(kSize, truth)),
                                               prior);
    EXPECT_THAT(r, IsMotion(truth, 0.02, 0.02)) << i;
  }
}

TEST_F(RegistrarTest, UnderEqualTilesASharpPriorChoosesAndThatIsSaid) {
  const SyntheticCeiling tiles(
      {.tile_px = 80, .tile_grey = 0, .speckle_grey = 0, .lamps = false, .marks = false});
  const ImageMotion truth{31, -17, 0.02, 1};
  const FrameSpectrum a = registrar_.Analyze(tiles.Render(kSize, {}, 1, 1));
  const FrameSpectrum b = registrar_.Analyze(tiles.Render(kSize, truth, 1, 2));
  const Registration r = registrar_.Register(a, b, MotionPrior{truth, 4, 0.15});
  EXPECT_THAT(r, IsMotion(truth, 0.1, 0.1));
  EXPECT_TRUE(r.disambiguated_by_prior);
}

TEST_F(RegistrarTest, LittleCommonAreaIsMostlyEnoughAndNeverMisleads) {
  std::mt19937 random(10);
  int answers = 0;
  constexpr int kPairs = 16;
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    const SyntheticCeiling ceiling({.seed = 90 + i, .tile_px = i % 3 == 0 ? 0.0 : 90.0 + i});
    ImageMotion truth;
    do {
      truth = RandomMotion(random, false, 0.3);
    } while (OverlapOf(truth, kSize) > 0.5);
    const Registration r = Register(ceiling.Render(kSize), ceiling.Render(kSize, truth));
    if (!r.ok()) continue;
    ++answers;
    EXPECT_THAT(r, IsMotion(truth, 0.04, 0.02)) << i;
  }
  EXPECT_GE(answers, kPairs * 3 / 4);
}

TEST_F(RegistrarTest, OverlapIsThePartOfTheReferenceInView) {
  const SyntheticCeiling ceiling;
  const FrameSpectrum reference = registrar_.Analyze(ceiling.Render(kSize));
  for (const ImageMotion& truth : {ImageMotion{160, 0, 0, 1},
                                   ImageMotion{0, -120, kPi, 1},
                                   ImageMotion{0, 0, kPi / 2, 1},
                                   ImageMotion{140, 60, 0.8, 1}}) {
    const FrameSpectrum current = registrar_.Analyze(ceiling.Render(kSize, truth));
    const Registration r = registrar_.Register(reference, current);
    ASSERT_TRUE(r.ok());
    EXPECT_NEAR(r.overlap, OverlapOf(truth, kSize), 0.02) << truth.theta_rad;
  }
}

TEST_F(RegistrarTest, RandomMotionsWithScale) {
  Registrar registrar(kSize, WithScale());
  std::mt19937 random(2);
  constexpr std::uint32_t kPairs = 32;
  int unanswered = 0;  // at little overlap a pair in thirty is
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    const SyntheticCeiling ceiling({.seed = 50 + i, .tile_px = i % 3 == 0 ? 0.0 : 90.0 + i});
    const ImageMotion truth = RandomMotion(random, true, 0.35);
    const FrameSpectrum a = registrar.Analyze(ceiling.Render(kSize));
    const FrameSpectrum b = registrar.Analyze(ceiling.Render(kSize, truth));
    const Registration found = registrar.Register(a, b);
    unanswered += found.ok() ? 0 : 1;
    if (!found.ok()) continue;
    EXPECT_THAT(found, IsMotion(truth, 0.03, 0.02)) << i;
  }
  EXPECT_LE(unanswered, 2);
}

TEST_F(RegistrarTest, LampsThatAreSwitchedOff) {
  const ImageMotion truth{40, -25, 0.3, 1};
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const SyntheticCeiling lit({.seed = seed});
    const SyntheticCeiling dark({.seed = seed, .lamps = false});
    EXPECT_THAT(Register(lit.Render(kSize), dark.Render(kSize, truth)), IsMotion(truth, 0.05, 0.03))
        << seed;
  }
}

TEST_F(RegistrarTest, ImagesOfWhichPartsHaveNoContent) {
  const ImageMotion truth{-30, 20, -0.2, 1};
  const SyntheticCeiling ceiling;
  Registrar registrar(kSize);
  cv::Mat part = ceiling.Render(kSize);
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(255));
  mask(cv::Rect(0, 0, 250, kSize.height)).setTo(0);
  part.setTo(0, mask == 0);
  const FrameSpectrum masked = registrar.Analyze(part, mask);
  const FrameSpectrum whole = registrar.Analyze(ceiling.Render(kSize, truth));
  const Registration as_reference = registrar.Register(masked, whole);
  EXPECT_THAT(as_reference, IsMotion(truth, 0.03, 0.02));
  EXPECT_THAT(registrar.Register(whole, masked), IsMotion(truth.Inverse(), 0.03, 0.02));
  // No block that lies in the blank part was compared.
  const Dissimilarity dissimilarity = registrar.Compare(whole, masked, truth.Inverse());
  EXPECT_GT(dissimilarity.blocks, 10);
  EXPECT_LT(dissimilarity.mean, 0.3);
  EXPECT_LT(as_reference.blocks, registrar.Register(whole, whole).blocks);
  EXPECT_THROW((void)registrar.Analyze(part, cv::Mat(10, 10, CV_8UC1)), InputError);
}

TEST_F(RegistrarTest, ShiftsByHalfTheFrame) {
  const SyntheticCeiling ceiling;
  const cv::Mat reference = ceiling.Render(kSize);
  for (const ImageMotion& truth : {ImageMotion{320, 0, 0, 1},
                                   ImageMotion{-319.5, 20, 0.01, 1},
                                   ImageMotion{10, 240, 0, 1},
                                   ImageMotion{0, -230.25, kPi, 1}}) {
    EXPECT_THAT(Register(reference, ceiling.Render(kSize, truth)), IsMotion(truth, 0.02, 0.02));
  }
}

TEST_F(RegistrarTest, SpecialAngles) {
  const SyntheticCeiling ceiling;
  const cv::Mat reference = ceiling.Render(kSize);
  for (const double theta : {0.0, 1e-3, kPi / 4, kPi / 2, -kPi / 2, kPi, 170 * kPi / 180}) {
    const ImageMotion truth{3.4, -5.6, theta, 1};
    EXPECT_THAT(Register(reference, ceiling.Render(kSize, truth)), IsMotion(truth, 0.02, 0.02));
  }
}

TEST_F(RegistrarTest, AImageAgreesWithItself) {
  const cv::Mat image = SyntheticCeiling().Render(kSize);
  const Registration r = Register(image, image);
  EXPECT_THAT(r, IsMotion(ImageMotion{}, 1e-3, 1e-4));
  EXPECT_NEAR(r.overlap, 1, 0.02);
  EXPECT_EQ(r.inliers, r.blocks);
  EXPECT_GT(r.peak, 0.95);
}

TEST_F(RegistrarTest, BackwardsIsTheInverse) {
  std::mt19937 random(3);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const SyntheticCeiling ceiling({.seed = 20 + i});
    const ImageMotion truth = RandomMotion(random, false, 0.5);
    const FrameSpectrum a = registrar_.Analyze(ceiling.Render(kSize));
    const FrameSpectrum b = registrar_.Analyze(ceiling.Render(kSize, truth));
    const Registration forwards = registrar_.Register(a, b);
    const Registration backwards = registrar_.Register(b, a);
    ASSERT_TRUE(forwards.ok() && backwards.ok());
    const ImageMotion round = Compose(backwards.motion, forwards.motion);
    EXPECT_LT(ShiftError(round, {}), 0.02);
    EXPECT_LT(AngleErrorDeg(round, {}), 0.01);
  }
}

TEST_F(RegistrarTest, ThreeFramesCompose) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (std::uint32_t i = 0; i < 5; ++i) {
    const SyntheticCeiling ceiling({.seed = 30 + i});
    const auto step = [&] {
      return ImageMotion{90 * unit(random), 90 * unit(random), 2 * unit(random), 1};
    };
    const ImageMotion to_b = step();
    const ImageMotion to_c = Compose(step(), to_b);
    const FrameSpectrum a = registrar_.Analyze(ceiling.Render(kSize));
    const FrameSpectrum b = registrar_.Analyze(ceiling.Render(kSize, to_b));
    const FrameSpectrum c = registrar_.Analyze(ceiling.Render(kSize, to_c));
    const Registration ab = registrar_.Register(a, b);
    const Registration bc = registrar_.Register(b, c);
    const Registration ac = registrar_.Register(a, c);
    ASSERT_TRUE(ab.ok() && bc.ok() && ac.ok()) << i;
    const ImageMotion composed = Compose(bc.motion, ab.motion);
    EXPECT_LT(ShiftError(composed, ac.motion), 0.03);
    EXPECT_LT(AngleErrorDeg(composed, ac.motion), 0.01);
  }
}

TEST_F(RegistrarTest, Noise) {
  std::mt19937 random(5);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const SyntheticCeiling ceiling({.seed = 60 + i});
    const ImageMotion truth = RandomMotion(random, false, 0.5);
    const cv::Mat reference = ceiling.Render(kSize, {}, 5, 2 * i);
    const Registration r = Register(reference, ceiling.Render(kSize, truth, 5, 2 * i + 1));
    EXPECT_THAT(r, IsMotion(truth, 0.12, 0.04)) << i;
    // The error is one that the reported covariance expects.
    const double sigma = std::sqrt(r.covariance(0, 0) + r.covariance(1, 1));
    EXPECT_LT(ShiftError(r.motion, truth), 4 * sigma) << i;
    EXPECT_LT(sigma, 0.12);
  }
}

TEST_F(RegistrarTest, CovarianceIsSymmetricAndPositive) {
  const SyntheticCeiling ceiling;
  Registrar with_scale(kSize, WithScale());
  const cv::Mat first = ceiling.Render(kSize, {}, 3, 1);
  const cv::Mat second = ceiling.Render(kSize, {20, 10, 0.4, 1}, 3, 2);
  const Eigen::Matrix4d rigid = Register(first, second).covariance;
  EXPECT_EQ(rigid.row(3).norm() + rigid.col(3).norm(), 0) << "the scale is held";
  const FrameSpectrum a = with_scale.Analyze(first);
  const Eigen::Matrix4d similar = with_scale.Register(a, with_scale.Analyze(second)).covariance;
  for (const Eigen::MatrixXd& c :
       {Eigen::MatrixXd(rigid.topLeftCorner<3, 3>()), Eigen::MatrixXd(similar)}) {
    EXPECT_LT((c - c.transpose()).norm(), 1e-12);
    EXPECT_GT(c.llt().matrixL().determinant(), 0);
    EXPECT_EQ(c.llt().info(), Eigen::Success);
  }
}

TEST_F(RegistrarTest, Exposure) {
  std::mt19937 random(6);
  for (const auto& [gain, offset] : {std::pair{0.55, 10.0}, {1.3, -30.0}, {0.8, 50.0}}) {
    const SyntheticCeiling ceiling({.seed = 70});
    const ImageMotion truth = RandomMotion(random, false, 0.5);
    cv::Mat other;
    ceiling.RenderFloat(kSize, truth).convertTo(other, CV_8U, gain, offset);
    EXPECT_THAT(Register(ceiling.Render(kSize), other), IsMotion(truth, 0.03, 0.02));
  }
}

TEST_F(RegistrarTest, LightThatFallsOffToOneSide) {
  const SyntheticCeiling ceiling;
  const ImageMotion truth{40, -25, 0.5, 1};
  cv::Mat image = ceiling.RenderFloat(kSize, truth);
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) image.at<float>(v, u) *= 0.6F + 0.0006F * u;
  }
  cv::Mat shaded;
  image.convertTo(shaded, CV_8U);
  EXPECT_THAT(Register(ceiling.Render(kSize), shaded), IsMotion(truth, 0.03, 0.02));
}

TEST_F(RegistrarTest, MotionBlurOfOneImage) {
  std::mt19937 random(7);
  for (const cv::Size smear : {cv::Size(7, 1), cv::Size(1, 9), cv::Size(5, 5)}) {
    const SyntheticCeiling ceiling({.seed = 80});
    const ImageMotion truth = RandomMotion(random, false, 0.5);
    cv::Mat blurred;
    cv::blur(ceiling.Render(kSize, truth), blurred, smear);
    EXPECT_THAT(Register(ceiling.Render(kSize), blurred), IsMotion(truth, 0.15, 0.05)) << smear;
  }
}

TEST_F(RegistrarTest, StrongMotionBlurNeverMisleads) {
  // A smear of 15 px turns the sign of all but the lowest band: twin peaks on both sides of the
  // truth.
  for (std::uint32_t i = 0; i < 4; ++i) {
    const SyntheticCeiling ceiling({.seed = 60 + i});
    const ImageMotion truth{90.0 - 20 * i, -60.0 + 33 * i, -2 + 0.9 * i, 1};
    cv::Mat blurred;
    cv::blur(ceiling.Render(kSize, truth, 2, i + 50), blurred, {15, 1});
    const Registration r = Register(ceiling.Render(kSize, {}, 2, i), blurred);
    const double error = r.ok() ? ShiftError(r.motion, truth) : 0;
    EXPECT_LT(error, 1) << i;
  }
}

TEST_F(RegistrarTest, APriorIsNotMixedIntoTheResult) {
  const SyntheticCeiling ceiling;
  const ImageMotion truth{33, 12, 0.3, 1};
  const cv::Mat reference = ceiling.Render(kSize);
  const cv::Mat current = ceiling.Render(kSize, truth);
  const Registration alone = Register(reference, current);
  const Registration misled = Register(reference, current, MotionPrior{{-100, 50, 2, 1}, 1, 0.01});
  EXPECT_EQ(misled.verdict, Verdict::kOk);
  EXPECT_EQ(misled.motion.tx_px, alone.motion.tx_px);
  EXPECT_EQ(misled.motion.theta_rad, alone.motion.theta_rad);
}

TEST_F(RegistrarTest, RefineFromNearby) {
  const SyntheticCeiling ceiling;
  const ImageMotion truth{-70.4, 31.9, 2.2, 1};
  const FrameSpectrum a = registrar_.Analyze(ceiling.Render(kSize));
  const FrameSpectrum b = registrar_.Analyze(ceiling.Render(kSize, truth));
  ImageMotion start = truth;
  start.tx_px += 8;
  start.ty_px -= 5;
  start.theta_rad += 1.5 * kPi / 180;
  EXPECT_THAT(registrar_.Refine(a, b, start), IsMotion(truth, 0.01, 0.005));
  start.tx_px += 60;
  EXPECT_EQ(registrar_.Refine(a, b, start).verdict, Verdict::kNoMatch);
}

TEST_F(RegistrarTest, RefineTakesNoisyAndBlurredFrames) {
  // A moving frame against a sharp map: what Register answers, Refine answers as well.
  const SyntheticCeiling ceiling;
  const ImageMotion truth{-30.4, 21.9, 1.2, 1};
  const FrameSpectrum a = registrar_.Analyze(ceiling.Render(kSize, {}, 2, 1));
  ImageMotion start = truth;
  start.tx_px += 3;
  start.theta_rad += 0.01;
  cv::Mat blurred;
  cv::blur(ceiling.Render(kSize, truth, 2, 2), blurred, {7, 1});
  EXPECT_THAT(registrar_.Refine(a, registrar_.Analyze(blurred), start),
              IsMotion(truth, 0.15, 0.05));
  const cv::Mat noisy = ceiling.Render(kSize, truth, 10, 3);
  EXPECT_THAT(registrar_.Refine(a, registrar_.Analyze(noisy), start), IsMotion(truth, 0.15, 0.05));
}

}  // namespace
}  // namespace ceilmap::registration
