// Images that a codec has robbed of their texture.

#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>
#include <random>
#include <vector>

#include "mapping/registration/rivals.hpp"
#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

// Quantized coefficients of blocks, as in a frame of a video that depends on no other.
cv::Mat Encoded(const cv::Mat& image, int quality) {
  std::vector<unsigned char> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
}

class RegistrarEncodedTest : public RegistrarTest {
 protected:
  static cv::Mat Shot(std::uint32_t seed, const ImageMotion& motion, double tile_px = 110) {
    constexpr int kQuality = 8;
    const SyntheticCeiling ceiling({.seed = seed, .tile_px = tile_px, .speckle_grey = 8});
    return Encoded(ceiling.Render(kSize, motion, 1.5, seed), kQuality);
  }
  // Of neighbouring frames of a drive.
  static ImageMotion SmallMotion(std::mt19937& random) {
    std::uniform_real_distribution<double> unit(-1, 1);
    return {60 * unit(random), 60 * unit(random), 0.3 * unit(random), 1};
  }
  // A motion that is found is the right one.
  static bool IsFound(const Registration& r, const ImageMotion& truth) {
    if (!r.ok()) return false;
    EXPECT_THAT(r, IsMotion(truth, 1.0, 0.3));
    return true;
  }
  static MotionPrior PriorNear(const ImageMotion& truth, double off_px) {
    return {{truth.tx_px + off_px, truth.ty_px, truth.theta_rad + 0.03, 1}, 6, 0.1};
  }
};

TEST_F(RegistrarEncodedTest, TheyAreKnownByTheirMissingNoise) {
  const SyntheticCeiling ceiling;
  EXPECT_GT(registrar_.Analyze(Shot(1, {})).CodingLoss(), 0.5);
  EXPECT_EQ(registrar_.Analyze(ceiling.Render(kSize, {}, 1.5)).CodingLoss(), 0);
  EXPECT_EQ(FrameSpectrum().CodingLoss(), 0);
}

TEST_F(RegistrarEncodedTest, APredictedMotionNeedsLessEvidence) {
  std::mt19937 random(4);
  int found = 0;
  int without_prediction = 0;
  constexpr int kPairs = 16;
  for (std::uint32_t seed = 1; seed <= kPairs; ++seed) {
    const ImageMotion truth = SmallMotion(random);
    const cv::Mat reference = Shot(seed, {});
    const cv::Mat current = Shot(seed, truth);
    without_prediction += Register(reference, current).ok() ? 1 : 0;
    const Registration r = Register(reference, current, PriorNear(truth, 7));
    if (!IsFound(r, truth)) continue;
    ++found;
    const double sigma_px = std::sqrt(r.covariance.diagonal().head<2>().maxCoeff());
    EXPECT_LT(ShiftError(r.motion, truth), 4 * sigma_px) << seed;
  }
  EXPECT_GE(found, kPairs - 2);
  EXPECT_GT(found, without_prediction);
}

TEST_F(RegistrarEncodedTest, AnImageDrawnFromOneKeepsItsEncoding) {
  const FrameSpectrum taken = registrar_.Analyze(Shot(1, {}), {}, {.predicted = true});
  EXPECT_TRUE(taken.GetEncoding().predicted);
  EXPECT_EQ(taken.GetEncoding().loss, taken.CodingLoss());
  const cv::Mat noisy = SyntheticCeiling().Render(kSize, {}, 3);
  EXPECT_NEAR(
      registrar_.Analyze(noisy, {}, taken.GetEncoding()).CodingLoss(), taken.CodingLoss(), 1e-6);
  EXPECT_FALSE(registrar_.Analyze(noisy).GetEncoding().predicted);
  EXPECT_FALSE(FrameSpectrum().GetEncoding().predicted);
}

TEST_F(RegistrarEncodedTest, ARectifiedImageHasTheLossOfTheImageAsTaken) {
  const FrameSpectrum drawn = registrar_.Analyze(Shot(1, {}), {}, {.loss_as_taken = 0});
  EXPECT_FALSE(drawn.IsEncoded());
  EXPECT_FALSE(drawn.IsDistorted());
  EXPECT_GT(drawn.SmoothingLoss(), 0.5);
  const FrameSpectrum level =
      registrar_.Analyze(SyntheticCeiling().Render(kSize, {}, 3), {}, drawn.GetEncoding());
  EXPECT_EQ(level.CodingLoss(), 0);
  EXPECT_NEAR(level.SmoothingLoss(), drawn.SmoothingLoss(), 1e-6);
}

// Agreement near the prediction is enough for a codec's images only; being alike but for the errors
// of drawing is enough for rectified ones too.
TEST(ExpectedMotion, OfRectifiedImagesNeedsMoreThanAgreement) {
  Finalist finalist;
  finalist.determined = true;
  finalist.total_agreement = 1.5;
  finalist.result.inliers = 40;
  finalist.result.blocks = 48;
  finalist.result.motion = {30, -10, 0.1, 1};
  const MotionPrior prior{{31, -10, 0.1, 1}, 6, 0.1};
  EXPECT_TRUE(FindExpected({finalist}, prior, true));
  EXPECT_FALSE(FindExpected({finalist}, prior, false));
  finalist.alike_but_for_codec = true;
  EXPECT_TRUE(FindExpected({finalist}, prior, false));
}

TEST_F(RegistrarEncodedTest, ACoarseImageOfFewBitsIsStarved) {
  const auto is_starved = [&](const cv::Mat& image, double rate_bit_s) {
    return registrar_.Analyze(image, {}, {.pixel_rate_bit_s = rate_bit_s}).IsStarved();
  };
  const cv::Mat coarse = Shot(1, {});
  EXPECT_TRUE(registrar_.Analyze(coarse).IsDistorted());
  EXPECT_TRUE(is_starved(coarse, 0.02));
  EXPECT_FALSE(is_starved(coarse, 0.1));
  EXPECT_FALSE(is_starved(coarse, 0)) << "unknown";
  // The robot stands, and its image is sharp all the same.
  const cv::Mat fine = SyntheticCeiling().Render(kSize, {}, 1.5);
  EXPECT_FALSE(is_starved(fine, 0.02));
  EXPECT_FALSE(FrameSpectrum().IsStarved());
  const FrameSpectrum starved = registrar_.Analyze(coarse, {}, {.pixel_rate_bit_s = 0.02});
  EXPECT_TRUE(registrar_.Analyze(fine, {}, starved.GetEncoding()).IsStarved()) << "drawn from it";
}

// The map's image has its noise, as of a camera that was not encoded.
TEST_F(RegistrarEncodedTest, AgainstAMapTheCodecOfTheCurrentImageCounts) {
  RegistrarParams params;
  params.same_recording = false;
  Registrar registrar(kSize, params);
  std::mt19937 random(5);
  int found = 0;
  int as_of_a_camera = 0;
  constexpr int kPairs = 16;
  for (std::uint32_t seed = 1; seed <= kPairs; ++seed) {
    const ImageMotion truth = SmallMotion(random);
    const SyntheticCeiling ceiling({.seed = seed, .tile_px = 110, .speckle_grey = 8});
    const FrameSpectrum map = registrar.Analyze(ceiling.Render(kSize, {}, 1.5, seed + 50));
    const cv::Mat current = Shot(seed, truth);
    const MotionPrior prior = PriorNear(truth, 7);
    as_of_a_camera += registrar.Register(map, registrar.Analyze(current), prior).ok() ? 1 : 0;
    const Registration r =
        registrar.Register(map, registrar.Analyze(current, {}, {.predicted = true}), prior);
    found += IsFound(r, truth) ? 1 : 0;
  }
  EXPECT_GE(found, kPairs - 2);
  EXPECT_GT(found, as_of_a_camera);
}

TEST_F(RegistrarEncodedTest, NothingIsFoundBetweenOtherPlaces) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    const double tile_px = seed % 2 == 0 ? 0 : 90;
    const cv::Mat here = Shot(seed, {}, tile_px);
    const cv::Mat there = Shot(seed + 100, {}, 1.13 * tile_px);
    EXPECT_FALSE(Register(here, there, PriorNear({20, -10, 0.1, 1}, 0)).ok()) << seed;
  }
}

}  // namespace
}  // namespace ceilmap::registration
