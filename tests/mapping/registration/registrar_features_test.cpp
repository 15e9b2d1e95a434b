// Local features propose the motion where the amplitude spectra do not suffice.

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

RegistrarParams WithFeatures() {
  RegistrarParams params;
  params.local_features = true;
  return params;
}

class RegistrarFeaturesTest : public RegistrarTest {
 protected:
  Registration RegisterWithFeatures(const cv::Mat& reference, const cv::Mat& current) {
    const FrameSpectrum a = features_.Analyze(reference);
    return features_.Register(a, features_.Analyze(current));
  }

  Registrar features_{kSize, WithFeatures()};
};

TEST_F(RegistrarFeaturesTest, LittleInCommon) {
  const SyntheticCeiling ceiling({.tile_px = 0, .speckle_grey = 12});
  const cv::Mat reference = ceiling.Render(kSize, {}, 1, 1);
  for (const ImageMotion& truth : {ImageMotion{440, 170, 0.4, 1},
                                   ImageMotion{-140, -370, -1.3, 1},
                                   ImageMotion{410, -160, 2.9, 1}}) {
    ASSERT_THAT(OverlapOf(truth, kSize), testing::AllOf(testing::Gt(0.12), testing::Lt(0.3)));
    const cv::Mat current = ceiling.Render(kSize, truth, 1, 2);
    EXPECT_EQ(Register(reference, current).verdict, Verdict::kNoMatch);
    EXPECT_THAT(RegisterWithFeatures(reference, current), IsMotion(truth, 0.2, 0.05));
  }
}

TEST_F(RegistrarFeaturesTest, PerspectiveIsAcceptedWithItsErrors) {
  // A keystone distortion of 14 px at the right border: the blocks do not agree with one motion.
  const SyntheticCeiling ceiling({.tile_px = 0, .speckle_grey = 12});
  const ImageMotion truth{230, 60, 0.3, 1};
  const double keystone = 1.4e-4;
  const cv::Matx33d to_centre(1, 0, -319.5, 0, 1, -239.5, 0, 0, 1);
  const cv::Matx33d distort(1, 0, 0, 0, 1, 0, keystone, 0, 1);
  cv::Mat current;
  cv::warpPerspective(ceiling.Render(kSize, truth, 1, 2),
                      current,
                      to_centre.inv() * distort * to_centre,
                      kSize,
                      cv::INTER_CUBIC,
                      cv::BORDER_REFLECT);
  const cv::Mat reference = ceiling.Render(kSize, {}, 1, 1);
  EXPECT_FALSE(Register(reference, current).ok());
  const Registration found = RegisterWithFeatures(reference, current);
  ASSERT_TRUE(found.ok());
  const double error = ShiftError(found.motion, truth);
  EXPECT_LT(error, 12);
  EXPECT_GT(std::sqrt(found.covariance(0, 0)), 0.5);
}

TEST_F(RegistrarFeaturesTest, OtherPlacesAreRefused) {
  for (std::uint32_t i = 0; i < 20; ++i) {
    const bool tiles = i % 2 == 0;
    const SyntheticCeiling ceiling({.seed = 300 + i, .tile_px = tiles ? 80.0 : 0.0});
    const ImageMotion far{4000.0 + 37 * i, -3000, 0.3 * i, 1};
    const Registration r = RegisterWithFeatures(ceiling.Render(kSize, {}, 2, i),
                                                ceiling.Render(kSize, far, 2, i + 500));
    EXPECT_FALSE(r.ok()) << i;
  }
}

TEST_F(RegistrarFeaturesTest, StrongMotionBlurNeverMisleads) {
  for (std::uint32_t i = 0; i < 4; ++i) {
    const SyntheticCeiling ceiling({.seed = 60 + i});
    const ImageMotion truth{90.0 - 20 * i, -60.0 + 33 * i, -2 + 0.9 * i, 1};
    cv::Mat blurred;
    cv::blur(ceiling.Render(kSize, truth, 2, i + 50), blurred, {15, 1});
    const Registration r = RegisterWithFeatures(ceiling.Render(kSize, {}, 2, i), blurred);
    EXPECT_LT(r.ok() ? ShiftError(r.motion, truth) : 0, 1) << i;
  }
}

TEST_F(RegistrarFeaturesTest, ABorderWithoutContentIsNotMatchedWithItself) {
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(0));
  cv::circle(mask, {320, 240}, 300, cv::Scalar(255), cv::FILLED);
  RegistrarParams params = WithFeatures();
  params.mask = mask;
  Registrar registrar(kSize, params);
  const SyntheticCeiling ceiling;
  const FrameSpectrum a = registrar.Analyze(ceiling.Render(kSize) & mask);
  const FrameSpectrum b = registrar.Analyze(ceiling.Render(kSize, {900, 700, 0.2, 1}) & mask);
  EXPECT_FALSE(registrar.Register(a, b).ok());
}

TEST_F(RegistrarFeaturesTest, SameInputSameOutput) {
  const SyntheticCeiling ceiling({.tile_px = 0, .speckle_grey = 12});
  const cv::Mat reference = ceiling.Render(kSize, {}, 1, 1);
  const cv::Mat current = ceiling.Render(kSize, {440, 170, 0.4, 1}, 1, 2);
  const ImageMotion first = RegisterWithFeatures(reference, current).motion;
  const ImageMotion second = RegisterWithFeatures(reference, current).motion;
  EXPECT_EQ(first.tx_px, second.tx_px);
  EXPECT_EQ(first.theta_rad, second.theta_rad);
}

}  // namespace
}  // namespace ceilmap::registration
