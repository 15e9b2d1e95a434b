#include "mapping/registration/registrar.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "calib/error.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

using synthetic::AngleErrorDeg;
using synthetic::CeilingParams;
using synthetic::ShiftError;
using synthetic::SyntheticCeiling;

const cv::Size kSize(640, 480);
constexpr double kPi = std::numbers::pi;

/// Random motion within half a frame, at least `min_overlap` of the reference in view.
ImageMotion RandomMotion(std::mt19937& random, bool scale, double min_overlap) {
  std::uniform_real_distribution<double> unit(-1, 1);
  while (true) {
    const ImageMotion motion{
        0.5 * kSize.width * unit(random),
        0.5 * kSize.height * unit(random),
        kPi * unit(random),
        scale ? std::exp(std::log(1.4) * std::max(unit(random), std::log(0.7) / std::log(1.4)))
              : 1.0};
    if (OverlapOf(motion, kSize) >= min_overlap) return motion;
  }
}

RegistrarParams WithScale() {
  RegistrarParams params;
  params.estimate_scale = true;
  return params;
}

MATCHER_P3(IsMotion, truth, bound_px, bound_deg, "") {
  const Registration& r = arg;
  *result_listener << ToString(r.verdict) << ", off by " << ShiftError(r.motion, truth) << " px, "
                   << AngleErrorDeg(r.motion, truth) << " deg, scale " << r.motion.scale
                   << ", truth " << truth.tx_px << " " << truth.ty_px << " " << truth.theta_rad
                   << " " << truth.scale << ", overlap " << OverlapOf(truth, kSize);
  return r.ok() && ShiftError(r.motion, truth) < bound_px &&
         AngleErrorDeg(r.motion, truth) < bound_deg &&
         std::abs(r.motion.scale / truth.scale - 1) < 2e-4;
}

class RegistrarTest : public testing::Test {
 protected:
  Registration Register(const cv::Mat& reference,
                        const cv::Mat& current,
                        const std::optional<MotionPrior>& prior = std::nullopt) {
    const FrameSpectrum a = registrar_.Analyze(reference);
    return registrar_.Register(a, registrar_.Analyze(current), prior);
  }

  Registrar registrar_{kSize};
};

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
  for (std::uint32_t i = 0; i < 16; ++i) {
    const SyntheticCeiling ceiling({.seed = 50 + i, .tile_px = i % 3 == 0 ? 0.0 : 90.0 + i});
    const ImageMotion truth = RandomMotion(random, true, 0.35);
    const FrameSpectrum a = registrar.Analyze(ceiling.Render(kSize));
    const FrameSpectrum b = registrar.Analyze(ceiling.Render(kSize, truth));
    EXPECT_THAT(registrar.Register(a, b), IsMotion(truth, 0.03, 0.02)) << i;
  }
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

TEST_F(RegistrarTest, APictureAgreesWithItself) {
  const cv::Mat picture = SyntheticCeiling().Render(kSize);
  const Registration r = Register(picture, picture);
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
  cv::Mat picture = ceiling.RenderFloat(kSize, truth);
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) picture.at<float>(v, u) *= 0.6F + 0.0006F * u;
  }
  cv::Mat shaded;
  picture.convertTo(shaded, CV_8U);
  EXPECT_THAT(Register(ceiling.Render(kSize), shaded), IsMotion(truth, 0.03, 0.02));
}

TEST_F(RegistrarTest, MotionBlurOfOnePicture) {
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

TEST_F(RegistrarTest, PicturesWithoutTexture) {
  const cv::Mat ceiling = SyntheticCeiling().Render(kSize);
  for (const int grey : {0, 128, 255}) {
    const cv::Mat uniform(kSize, CV_8UC1, cv::Scalar(grey));
    EXPECT_EQ(Register(uniform, ceiling).verdict, Verdict::kNoTexture) << grey;
    EXPECT_EQ(Register(ceiling, uniform).verdict, Verdict::kNoTexture) << grey;
    EXPECT_EQ(Register(uniform, uniform).verdict, Verdict::kNoTexture) << grey;
  }
}

TEST_F(RegistrarTest, NoiseAloneIsNeverRegistered) {
  for (std::uint32_t i = 0; i < 5; ++i) {
    const SyntheticCeiling nothing(
        {.tile_px = 0, .speckle_grey = 0, .lamps = false, .marks = false});
    const Registration r =
        Register(nothing.Render(kSize, {}, 4, 2 * i), nothing.Render(kSize, {}, 4, 2 * i + 1));
    EXPECT_FALSE(r.ok()) << i;
  }
}

TEST_F(RegistrarTest, UnrelatedPicturesDoNotMatch) {
  Registrar with_scale(kSize, WithScale());
  int not_matched = 0;
  constexpr int kPairs = 60;
  for (std::uint32_t i = 0; i < kPairs; ++i) {
    // Plaster against plaster, and tiles against tiles of another size.
    const bool tiles = i % 2 == 0;
    const SyntheticCeiling here({.seed = 1000 + i, .tile_px = tiles ? 80.0 : 0.0});
    const SyntheticCeiling there({.seed = 2000 + i, .tile_px = tiles ? 127.0 : 0.0});
    Registrar& registrar = i % 3 == 0 ? with_scale : registrar_;
    const FrameSpectrum a = registrar.Analyze(here.Render(kSize, {}, 2, i));
    const FrameSpectrum b = registrar.Analyze(there.Render(kSize, {}, 2, i + 500));
    const Registration r = registrar.Register(a, b);
    EXPECT_FALSE(r.ok()) << i << ", peak " << r.peak << ", runner-up " << r.runner_up;
    not_matched += r.verdict == Verdict::kNoMatch ? 1 : 0;
  }
  EXPECT_GE(not_matched, kPairs - 6) << "the lines between tiles may be called ambiguous";
}

TEST_F(RegistrarTest, OtherPlacesOfATiledCeilingAreNeverTakenForSure) {
  // The grid fits everywhere; grain, marks and lamps say that it is another place.
  for (std::uint32_t i = 0; i < 20; ++i) {
    const SyntheticCeiling ceiling({.seed = 300 + i});
    const ImageMotion far{4000.0 + 37 * i, -3000, 0.3 * i, 1};
    const Registration r =
        Register(ceiling.Render(kSize, {}, 2, i), ceiling.Render(kSize, far, 2, i + 500));
    EXPECT_FALSE(r.ok()) << i << ", peak " << r.peak << ", runner-up " << r.runner_up;
  }
}

TEST_F(RegistrarTest, NoCommonAreaDoesNotMatch) {
  const SyntheticCeiling ceiling({.tile_px = 0});
  const cv::Mat reference = ceiling.Render(kSize);
  for (const ImageMotion& far : {ImageMotion{700, 0, 0, 1}, ImageMotion{0, -520, 1, 1}}) {
    EXPECT_EQ(Register(reference, ceiling.Render(kSize, far)).verdict, Verdict::kNoMatch);
  }
}

/// Square tiles and nothing else.
CeilingParams BareTiles(double tile_px) {
  return {.tile_px = tile_px, .tile_grey = 0, .speckle_grey = 0, .lamps = false, .marks = false};
}

TEST_F(RegistrarTest, PeriodicTilesAreAmbiguous) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double tile_px : {60.0, 97.0, 130.0}) {
    const SyntheticCeiling ceiling(BareTiles(tile_px));
    const ImageMotion truth{
        0.4 * tile_px * unit(random), 0.4 * tile_px * unit(random), 0.2 * unit(random), 1};
    const cv::Mat reference = ceiling.Render(kSize, {}, 1, 1);
    const cv::Mat current = ceiling.Render(kSize, truth, 1, 2);
    const Registration alone = Register(reference, current);
    if (alone.verdict != Verdict::kAmbiguous) {
      EXPECT_THAT(alone, IsMotion(truth, 0.1, 0.05)) << tile_px;
    }
    MotionPrior prior{truth, tile_px / 12, 0.1};
    prior.motion.tx_px += 0.05 * tile_px;
    prior.motion.theta_rad -= 0.05;
    const Registration guided = Register(reference, current, prior);
    EXPECT_THAT(guided, IsMotion(truth, 0.1, 0.05)) << tile_px;
  }
}

TEST_F(RegistrarTest, OneMarkSettlesPeriodicTiles) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 6; ++i) {
    CeilingParams params = BareTiles(75 + 8 * i);
    // Off all the places about which the grid could be turned or mirrored.
    params.own_marks = {{0.27 * params.tile_px, 0.11 * params.tile_px}};
    const SyntheticCeiling ceiling(params);
    const ImageMotion truth{100 * unit(random), 80 * unit(random), kPi * unit(random), 1};
    const Registration r =
        Register(ceiling.Render(kSize, {}, 1, 1), ceiling.Render(kSize, truth, 1, 2));
    EXPECT_THAT(r, IsMotion(truth, 0.1, 0.05)) << i;
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

TEST_F(RegistrarTest, ABlankBorderIsNotMatchedWithItself) {
  // Rectified pictures have corners without content, which stand still while the ceiling moves.
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(255));
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      if (std::hypot(u - 319.5, v - 239.5) > 350) mask.at<std::uint8_t>(v, u) = 0;
    }
  }
  RegistrarParams params;
  params.mask = mask;
  Registrar registrar(kSize, params);
  const SyntheticCeiling ceiling;
  const FrameSpectrum a = registrar.Analyze(ceiling.Render(kSize) & mask);
  for (const ImageMotion& truth :
       {ImageMotion{2, 1, 0.01, 1}, ImageMotion{60, -40, 0.5, 1}, ImageMotion{-90, 100, -2.5, 1}}) {
    const FrameSpectrum b = registrar.Analyze(ceiling.Render(kSize, truth) & mask);
    EXPECT_THAT(registrar.Register(a, b), IsMotion(truth, 0.02, 0.02));
  }
}

TEST_F(RegistrarTest, RefineOfPicturesWithoutTexture) {
  const FrameSpectrum flat = registrar_.Analyze(cv::Mat(kSize, CV_8UC1, cv::Scalar(60)));
  EXPECT_FALSE(registrar_.Refine(flat, flat, {}).ok());
}

TEST(Registrar, OtherSizes) {
  for (const cv::Size size :
       {cv::Size(320, 240), cv::Size(641, 479), cv::Size(1280, 720), cv::Size(300, 400)}) {
    Registrar registrar(size);
    const SyntheticCeiling ceiling({.tile_px = 70});
    const ImageMotion truth{17.25, -23.5, 0.8, 1};
    const FrameSpectrum a = registrar.Analyze(ceiling.Render(size));
    const FrameSpectrum b = registrar.Analyze(ceiling.Render(size, truth));
    EXPECT_THAT(registrar.Register(a, b), IsMotion(truth, 0.02, 0.02)) << size;
  }
}

std::string MessageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const calib::InputError& error) {
    return error.what();
  }
  return "";
}

TEST_F(RegistrarTest, RefusesOtherPictures) {
  EXPECT_EQ(MessageOf([&] { (void)registrar_.Analyze(cv::Mat::zeros(kSize, CV_8UC3)); }),
            "picture of 640x480 where 640x480 grey is expected");
  EXPECT_EQ(MessageOf([&] { (void)registrar_.Analyze(cv::Mat::zeros(480, 641, CV_8UC1)); }),
            "picture of 641x480 where 640x480 grey is expected");
  EXPECT_THROW((void)registrar_.Analyze(cv::Mat()), calib::InputError);
}

TEST_F(RegistrarTest, ARowStrideIsNoHindrance) {
  const SyntheticCeiling ceiling;
  cv::Mat wide(480, 700, CV_8UC1, cv::Scalar(0));
  const cv::Mat picture = ceiling.Render(kSize, {12, 5, 0.1, 1});
  picture.copyTo(wide(cv::Rect(30, 0, 640, 480)));
  const cv::Mat reference = ceiling.Render(kSize);
  const Registration dense = Register(reference, picture);
  const Registration strided = Register(reference, wide(cv::Rect(30, 0, 640, 480)));
  EXPECT_EQ(dense.motion.tx_px, strided.motion.tx_px);
  EXPECT_EQ(dense.motion.theta_rad, strided.motion.theta_rad);
}

TEST(Registrar, RefusesSizes) {
  EXPECT_EQ(MessageOf([] {
              Registrar registrar({95, 480});
            }),
            "pictures of 95x480 cannot be registered; each side must have 96 to 16384 pixels");
  EXPECT_THROW(Registrar({640, 16385}), calib::InputError);
  EXPECT_THROW(Registrar({0, 0}), calib::InputError);
  EXPECT_NO_THROW(Registrar({96, 96}));
}

TEST_F(RegistrarTest, RefusesEmptySpectra) {
  const FrameSpectrum a = registrar_.Analyze(SyntheticCeiling().Render(kSize));
  EXPECT_TRUE(FrameSpectrum().empty());
  EXPECT_FALSE(a.empty());
  EXPECT_THROW((void)registrar_.Register(a, {}), std::invalid_argument);
  EXPECT_THROW((void)registrar_.Register({}, a), std::invalid_argument);
  EXPECT_THROW((void)registrar_.Refine({}, a, {}), std::invalid_argument);
}

void ExpectSame(const Registration& a, const Registration& b) {
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.motion.tx_px, b.motion.tx_px);
  EXPECT_EQ(a.motion.ty_px, b.motion.ty_px);
  EXPECT_EQ(a.motion.theta_rad, b.motion.theta_rad);
  EXPECT_EQ(a.motion.scale, b.motion.scale);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.peak, b.peak);
  EXPECT_EQ(a.runner_up, b.runner_up);
  EXPECT_EQ(a.blocks, b.blocks);
  EXPECT_EQ(a.inliers, b.inliers);
}

TEST_F(RegistrarTest, SameInputSameBits) {
  const SyntheticCeiling ceiling;
  const cv::Mat reference = ceiling.Render(kSize, {}, 3, 1);
  const cv::Mat current = ceiling.Render(kSize, {-44, 61, 1.2, 1}, 3, 2);
  const cv::Mat other = ceiling.Render(kSize, {200, 5, 3, 1}, 3, 3);
  const Registration first = Register(reference, current);
  ASSERT_TRUE(first.ok());
  // Not even what the registrar did in between, or which registrar it is, matters.
  Register(other, current);
  ExpectSame(Register(reference, current), first);
  Registrar fresh(kSize);
  const FrameSpectrum a = fresh.Analyze(reference);
  ExpectSame(fresh.Register(a, fresh.Analyze(current)), first);
}

TEST_F(RegistrarTest, SpectraOutliveManyFramesThatCameAfter) {
  // Buffers are used again once no one holds them, and not before.
  const SyntheticCeiling ceiling;
  const ImageMotion truth{-44, 61, 1.2, 1};
  const FrameSpectrum reference = registrar_.Analyze(ceiling.Render(kSize));
  const FrameSpectrum current = registrar_.Analyze(ceiling.Render(kSize, truth));
  const Registration before = registrar_.Register(reference, current);
  const cv::Mat other = ceiling.Render(kSize, {500, 300, 0, 1});
  for (int i = 0; i < 20; ++i) {
    const FrameSpectrum passing = registrar_.Analyze(other);
    (void)registrar_.Register(passing, passing);
  }
  ExpectSame(registrar_.Register(reference, current), before);
}

TEST_F(RegistrarTest, TwoThreadsShareAReference) {
  const SyntheticCeiling ceiling;
  const cv::Mat reference_picture = ceiling.Render(kSize);
  constexpr std::size_t kFrames = 3;
  std::vector<cv::Mat> frames;
  for (std::size_t i = 0; i < 2 * kFrames; ++i) {
    const double step = static_cast<double>(i);
    frames.push_back(ceiling.Render(kSize, {15 * step - 40, 8 * step, 0.4 * step, 1}));
  }
  std::vector<Registration> alone;
  alone.reserve(frames.size());
  for (const cv::Mat& frame : frames) alone.push_back(Register(reference_picture, frame));

  // Both threads make the shared reference ready, at about the same time.
  const FrameSpectrum reference = registrar_.Analyze(reference_picture);
  std::vector<Registration> shared(frames.size());
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 2; ++t) {
    threads.emplace_back([&, t] {
      Registrar registrar(kSize);
      for (std::size_t i = t * kFrames; i < (t + 1) * kFrames; ++i) {
        shared[i] = registrar.Register(reference, registrar.Analyze(frames[i]));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_TRUE(alone[i].ok()) << i;
    ExpectSame(shared[i], alone[i]);
  }
}

TEST_F(RegistrarTest, SpectraMayEndInAnotherThread) {
  const SyntheticCeiling ceiling;
  const cv::Mat picture = ceiling.Render(kSize);
  const Registration expected = Register(picture, picture);
  std::vector<Registration> results(4);
  for (Registration& result : results) {
    const FrameSpectrum reference = registrar_.Analyze(picture);
    std::thread user([&result, spectrum = reference] {
      Registrar registrar(kSize);
      result = registrar.Register(spectrum, spectrum);
    });
    FrameSpectrum meanwhile = registrar_.Analyze(picture);
    user.join();
  }
  for (const Registration& result : results) ExpectSame(result, expected);
}

}  // namespace
}  // namespace ceilmap::registration
