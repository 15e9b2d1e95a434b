// Local features propose the motion where the amplitude spectra do not suffice.

#include <gmock/gmock.h>

#include <vector>

#include "tests/mapping/registration/registrar_fixture.hpp"

namespace ceilmap::registration {
namespace {

const std::vector<ImageMotion>& MotionsWithLittleInCommon() {
  static const std::vector<ImageMotion> motions{
      {440, 170, 0.4, 1}, {-140, -370, -1.3, 1}, {410, -160, 2.9, 1}};
  return motions;
}

TEST_F(RegistrarTest, LittleInCommonIsRegisteredByFeatures) {
  const SyntheticCeiling ceiling({.tile_px = 0, .speckle_grey = 12});
  const FrameSpectrum reference = registrar_.Analyze(ceiling.Render(kSize, {}, 1, 1));
  RegistrarParams spectra_alone;
  spectra_alone.local_features = false;
  Registrar without(kSize, spectra_alone);
  for (const ImageMotion& truth : MotionsWithLittleInCommon()) {
    ASSERT_THAT(OverlapOf(truth, kSize), testing::AllOf(testing::Gt(0.12), testing::Lt(0.3)));
    const FrameSpectrum current = registrar_.Analyze(ceiling.Render(kSize, truth, 1, 2));
    EXPECT_EQ(without.Register(reference, current).verdict, Verdict::kNoMatch);
    EXPECT_THAT(registrar_.Register(reference, current), IsMotion(truth, 0.2, 0.05));
  }
}

}  // namespace
}  // namespace ceilmap::registration
