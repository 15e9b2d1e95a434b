// Images with nothing, or nothing in common: no answer is the right one.

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

TEST_F(RegistrarTest, ImagesWithoutTexture) {
  const cv::Mat ceiling = SyntheticCeiling().Render(kSize);
  for (const int grey : {0, 128, 255}) {
    const cv::Mat uniform(kSize, CV_8UC1, cv::Scalar(grey));
    EXPECT_EQ(Register(uniform, ceiling).verdict, Verdict::kNoTexture) << grey;
    EXPECT_EQ(Register(ceiling, uniform).verdict, Verdict::kNoTexture) << grey;
    EXPECT_EQ(Register(uniform, uniform).verdict, Verdict::kNoTexture) << grey;
  }
}

TEST_F(RegistrarTest, WhiteImagesWithAFewDarkThings) {
  cv::Mat white(kSize, CV_8UC1, cv::Scalar(255));
  const cv::Mat grille = white(cv::Rect(kSize.width / 2, kSize.height / 2, 90, 60));
  for (int y = 0; y < grille.rows; y += 6) grille.row(y).setTo(120);
  EXPECT_EQ(Register(white, white).verdict, Verdict::kNoTexture);
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

/// A plain ceiling behind a lens that is darker towards the corners, in 8 bits.
cv::Mat Shaded(cv::Size size, std::uint32_t seed) {
  cv::RNG random(seed);
  cv::Mat image(size, CV_32FC1);
  random.fill(image, cv::RNG::NORMAL, 0, 1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double dx = (x - 0.5 * size.width) / size.width;
      const double dy = (y - 0.5 * size.height) / size.width;
      image.at<float>(y, x) += static_cast<float>(175 - 80 * (dx * dx + dy * dy));
    }
  }
  cv::Mat grey;
  image.convertTo(grey, CV_8U);
  return grey;
}

// The lens's shading is the same in both images: it looks as if the robot stood.
TEST_F(RegistrarTest, ShadingTellsNothing) {
  const FrameSpectrum here = registrar_.Analyze(Shaded(kSize, 1));
  const FrameSpectrum there = registrar_.Analyze(Shaded(kSize, 2));
  for (const ImageMotion& motion : {ImageMotion{}, ImageMotion{25, -10, 0.05, 1}}) {
    EXPECT_LT(registrar_.TellingRatio(here, there, motion), 0.05);
    // Blocks compared at any motion agree with it, unless their slopes are removed.
    EXPECT_FALSE(registrar_.Refine(here, there, motion).ok());
  }
  EXPECT_LT(registrar_.TexturedRatio(here), 0.45);
}

TEST_F(RegistrarTest, WeakTextureTells) {
  const SyntheticCeiling plaster({.tile_px = 0, .speckle_grey = 3, .lamps = false});
  const FrameSpectrum here = registrar_.Analyze(plaster.Render(kSize, {}, 1.5, 1));
  const FrameSpectrum there = registrar_.Analyze(plaster.Render(kSize, {}, 1.5, 2));
  EXPECT_GT(registrar_.TellingRatio(here, there, {}), 0.2);
  EXPECT_GT(registrar_.TexturedRatio(here), 0.9);
}

TEST_F(RegistrarTest, UnrelatedImagesDoNotMatch) {
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

TEST_F(RegistrarTest, OtherPlacesOfATiledCeilingAreNeverAccepted) {
  // The grid fits everywhere; grain, marks and lamps show that it is another place.
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

TEST_F(RegistrarTest, ABlankBorderIsNotMatchedWithItself) {
  // Rectified images have corners without content, which stand still while the ceiling moves.
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

TEST_F(RegistrarTest, RefineOfImagesWithoutTexture) {
  const FrameSpectrum flat = registrar_.Analyze(cv::Mat(kSize, CV_8UC1, cv::Scalar(60)));
  EXPECT_FALSE(registrar_.Refine(flat, flat, {}).ok());
}

}  // namespace
}  // namespace ceilmap::registration
