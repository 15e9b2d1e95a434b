// One place of a periodic ceiling, or another one of the same grid.

#include "mapping/registration/aliasing_check.hpp"

#include <gmock/gmock.h>

#include "mapping/registration/fine_stage.hpp"
#include "mapping/registration/noise.hpp"
#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

constexpr double kTilePx = 100;

/// Tiles with a grain of their own, everywhere another one.
CeilingParams GrainyTiles(double speckle_grey) {
  return {.tile_px = kTilePx,
          .tile_grey = 1,
          .speckle_grey = speckle_grey,
          .lamps = false,
          .marks = false};
}

class AliasingCheckTest : public testing::Test {
 protected:
  /// @param place  where the grid is as at place 0, tiles.
  void Show(const CeilingParams& ceiling,
            const Eigen::Vector2d& place,
            const ImageMotion& motion,
            std::uint32_t seed,
            FrameSpectrum::Data& data) {
    const ImageMotion there{-ceiling.tile_px * place.x(), -ceiling.tile_px * place.y(), 0, 1};
    const cv::Mat image =
        SyntheticCeiling(ceiling).Render(kSize, Compose(motion, there), 1.5, seed);
    data.noise = MakeNoise(EstimateNoise(image));
    fine_.Analyze(image, {}, data);
  }

  /// Of two images whose grids fit under `motion`, the second one taken some tiles away.
  AperiodicEvidence Compare(const CeilingParams& ceiling,
                            const ImageMotion& motion,
                            const Eigen::Vector2d& tiles_away) {
    Show(ceiling, {0, 0}, {}, 1, reference_);
    Show(ceiling, tiles_away, motion, 2, current_);
    distinguishes_ = check_.Distinguishes(reference_, current_, motion);
    const auto evidence = check_.Compare(reference_, current_, motion);
    EXPECT_TRUE(evidence);
    return evidence.value_or(AperiodicEvidence());
  }

  RegistrarParams params_;
  FineStage fine_{kSize, params_};
  AliasingCheck check_{kSize, params_};
  FrameSpectrum::Data reference_;
  FrameSpectrum::Data current_;
  bool distinguishes_ = false;
};

TEST_F(AliasingCheckTest, GrainDistinguishesPlaces) {
  for (const ImageMotion& motion :
       {ImageMotion{}, ImageMotion{90, -40, 0.3, 1}, ImageMotion{-120, 30, -2.2, 1}}) {
    const AperiodicEvidence here = Compare(GrainyTiles(10), motion, {0, 0});
    EXPECT_TRUE(distinguishes_);
    EXPECT_TRUE(here.has_grain);
    EXPECT_GT(here.grain, 2.4);
    EXPECT_LT(here.grain_of_rival, 0.8);
    const AperiodicEvidence elsewhere = Compare(GrainyTiles(10), motion, {50, 0});
    EXPECT_FALSE(distinguishes_);
    EXPECT_LT(elsewhere.grain, 0.8);
  }
}

TEST_F(AliasingCheckTest, AMotionOneTileFurtherIsRefused) {
  for (const Eigen::Vector2d& tiles : {Eigen::Vector2d(1, 0), {0, -1}, {1, 1}}) {
    const AperiodicEvidence evidence = Compare(GrainyTiles(10), {30, 20, 0.1, 1}, tiles);
    EXPECT_FALSE(distinguishes_);
    EXPECT_GT(evidence.grain_of_rival, evidence.grain + 1);  // the true motion is the rival
  }
}

TEST_F(AliasingCheckTest, WithoutGrainOrMarksNothingDistinguishes) {
  const AperiodicEvidence evidence = Compare(GrainyTiles(0), {30, 20, 0.1, 1}, {0, 0});
  EXPECT_FALSE(distinguishes_);
  EXPECT_FALSE(evidence.has_grain);
  EXPECT_EQ(evidence.mark_px, 0);
}

TEST_F(AliasingCheckTest, AMarkDistinguishesEqualTiles) {
  CeilingParams ceiling = GrainyTiles(0);
  ceiling.tile_px = 140;
  ceiling.tile_grey = 0;
  ceiling.own_marks = {{40, 15}};
  const AperiodicEvidence here = Compare(ceiling, {30, 20, 0.1, 1}, {0, 0});
  EXPECT_TRUE(distinguishes_);
  EXPECT_GT(here.mark_px, 100);
  EXPECT_GT(here.marks, 0.95);
  const AperiodicEvidence beside = Compare(ceiling, {30, 20, 0.1, 1}, {1, 0});
  EXPECT_FALSE(distinguishes_);
  EXPECT_LT(beside.marks, 0.5);
}

/// Through the registrar, as `ceilmap register` does it: without the check, this pair of other
/// places is a match.
TEST_F(AliasingCheckTest, RegistrarSaysAmbiguousWhereOnlyTheGridAgrees) {
  Registrar registrar(kSize);
  CeilingParams ceiling = GrainyTiles(7);
  ceiling.tile_grey = 5;
  const ImageMotion motion{20, -15, 0.02, 1};
  const FrameSpectrum here =
      registrar.Analyze(SyntheticCeiling(ceiling).Render(kSize, {}, 1.5, 10));
  const FrameSpectrum moved =
      registrar.Analyze(SyntheticCeiling(ceiling).Render(kSize, motion, 1.5, 11));
  EXPECT_THAT(registrar.RegisterAnyPlaces(here, moved), IsMotion(motion, 0.1, 0.05));
  ceiling.seed = 105;
  const FrameSpectrum elsewhere =
      registrar.Analyze(SyntheticCeiling(ceiling).Render(kSize, motion, 1.5, 11));
  EXPECT_TRUE(registrar.Register(here, elsewhere).ok());
  EXPECT_EQ(registrar.RegisterAnyPlaces(here, elsewhere).verdict, Verdict::kAmbiguous);
}

TEST_F(AliasingCheckTest, ACeilingWithoutPeriodIsNotJudged) {
  const CeilingParams plaster{.tile_px = 0, .lamps = false};
  Show(plaster, {0, 0}, {}, 1, reference_);
  Show(plaster, {9, 0}, {}, 2, current_);
  EXPECT_FALSE(check_.Compare(reference_, current_, {}).has_value());
  EXPECT_TRUE(check_.Distinguishes(reference_, current_, {}));
}

}  // namespace
}  // namespace ceilmap::registration
