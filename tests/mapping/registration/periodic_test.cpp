// Ceilings that repeat themselves, through a real lens: nothing but the camera differs from place
// to place, and that must not be taken for evidence.

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

/// Square tiles and nothing else.
CeilingParams BareTiles(double tile_px) {
  return {.tile_px = tile_px, .tile_grey = 0, .speckle_grey = 0, .lamps = false, .marks = false};
}

/// A third of the light is lost in the corners.
cv::Mat ThroughALens(const cv::Mat& image) {
  cv::Mat seen = image.clone();
  const double cu = 0.5 * (kSize.width - 1);
  const double cv = 0.5 * (kSize.height - 1);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      const double q = (std::pow(u - cu, 2) + std::pow(v - cv, 2)) / (cu * cu + cv * cv);
      auto& grey = seen.at<unsigned char>(v, u);
      grey = cv::saturate_cast<unsigned char>(grey * (1 - 0.35 * q));
    }
  }
  return seen;
}

class PeriodicCeiling : public testing::Test {
 protected:
  Registration Pair(const SyntheticCeiling& ceiling,
                    const ImageMotion& motion,
                    const std::optional<MotionPrior>& prior = std::nullopt) {
    const ImageMotion from{kPhase, -kPhase, 0, 1};
    const FrameSpectrum a = registrar_.Analyze(ThroughALens(ceiling.Render(kSize, from, 1.5, 1)));
    const FrameSpectrum b =
        registrar_.Analyze(ThroughALens(ceiling.Render(kSize, Compose(motion, from), 1.5, 2)));
    return registrar_.Register(a, b, prior);
  }

  static constexpr double kPhase = 13.7;
  Registrar registrar_{kSize};
};

TEST_F(PeriodicCeiling, IsAmbiguousThroughALensWithVignetting) {
  const SyntheticCeiling tiles(BareTiles(110));
  std::mt19937 random(11);
  std::uniform_real_distribution<double> shift(-220, 220);
  std::uniform_real_distribution<double> turn(-0.3, 0.3);
  for (int i = 0; i < 40; ++i) {
    const ImageMotion motion{shift(random), shift(random), turn(random), 1};
    const Registration result = Pair(tiles, motion);
    EXPECT_NE(result.verdict, Verdict::kOk) << motion.tx_px << ' ' << motion.ty_px << " answered "
                                            << result.motion.tx_px << ' ' << result.motion.ty_px;
  }
}

TEST_F(PeriodicCeiling, APredictionSettlesIt) {
  const SyntheticCeiling tiles(BareTiles(110));
  const ImageMotion motion{140, -60, 0.05, 1};
  const Registration result = Pair(tiles, motion, MotionPrior{{145, -57, 0.04, 1}, 10, 0.05});
  ASSERT_TRUE(result.ok());
  EXPECT_TRUE(result.disambiguated_by_prior);
  EXPECT_NEAR(result.motion.tx_px, motion.tx_px, 0.1);
  EXPECT_NEAR(result.motion.ty_px, motion.ty_px, 0.1);
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

}  // namespace
}  // namespace ceilmap::registration
