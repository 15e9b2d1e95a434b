#include "app/reports/recording_checks.hpp"

#include <gmock/gmock.h>

namespace ceilmap::reports {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

RecordingFacts Good() {
  RecordingFacts facts;
  facts.source = "up.mp4";
  facts.frames = 180;
  facts.bits_per_px = 0.3;
  return facts;
}

TEST(RecordingWarnings, NoneForAGoodRecording) {
  EXPECT_THAT(RecordingWarnings(Good()), IsEmpty());
}

TEST(RecordingWarnings, MissingFramesAskForStamps) {
  RecordingFacts facts = Good();
  facts.missing = 9;
  EXPECT_THAT(RecordingWarnings(facts),
              ElementsAre("up.mp4: about 9 of 189 frames are missing; give --stamps"));
  facts.has_stamps = true;
  EXPECT_THAT(RecordingWarnings(facts), IsEmpty());
  facts.has_stamps = false;
  facts.missing = 2;
  EXPECT_THAT(RecordingWarnings(facts), IsEmpty()) << "may be chance";
  facts.missing = 9;
  facts.frames = 1000;
  EXPECT_THAT(RecordingWarnings(facts), IsEmpty()) << "less than a hundredth";
}

TEST(RecordingWarnings, ALowBitrateIsStatedWithItsFigure) {
  RecordingFacts facts = Good();
  facts.coding_loss = 0.7;
  EXPECT_THAT(RecordingWarnings(facts), IsEmpty()) << "denoised, but stored well";
  facts.bits_per_px = 0.0288;
  EXPECT_THAT(
      RecordingWarnings(facts),
      ElementsAre("up.mp4: is compressed to 0.029 bits per pixel, which removes the texture "
                  "of the ceiling; record with 0.1 or more (x264: CRF 25 or less)"));
  facts.coding_loss = 0.2;
  EXPECT_THAT(RecordingWarnings(facts), IsEmpty()) << "small, but with all its noise";
}

TEST(RecordingWarnings, RepeatedFramesAreCounted) {
  RecordingFacts facts = Good();
  facts.repeated = 12;
  EXPECT_THAT(
      RecordingWarnings(facts),
      ElementsAre("up.mp4: 12 frames repeat the one before and give no pose: the codec "
                  "repeats them, or the camera does not deliver new ones; raise the bitrate, "
                  "or check the camera"));
}

}  // namespace
}  // namespace ceilmap::reports
