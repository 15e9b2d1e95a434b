#include "mapping/registration/noise.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "mapping/registration/encoding.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

using synthetic::SyntheticCeiling;

const cv::Size kNoiseSize(640, 480);

TEST(EstimateNoise, MeasuresWhiteNoise) {
  const SyntheticCeiling empty({.tile_px = 0, .speckle_grey = 0, .lamps = false, .marks = false});
  for (const double sigma : {1.0, 2.0, 5.0, 12.0}) {
    EXPECT_NEAR(EstimateNoise(empty.Render(kNoiseSize, {}, sigma)) / sigma, 1, 0.06) << sigma;
  }
  // Texture raises it a little.
  const float noise = EstimateNoise(SyntheticCeiling().Render(kNoiseSize, {}, 3));
  EXPECT_GT(noise, 2.9);
  EXPECT_LT(noise, 3.6);
}

TEST(EstimateNoise, NeverBelowTheRoundingToEightBits) {
  for (const int grey : {0, 128, 255}) {
    EXPECT_FLOAT_EQ(EstimateNoise(cv::Mat(kNoiseSize, CV_8UC1, cv::Scalar(grey))), 0.3F);
  }
}

TEST(CodedNoise, IsLargerWhereACodecRemovedTheNoise) {
  EXPECT_TRUE(MakeNoise(0.3F).IsEncoded());
  EXPECT_FALSE(MakeNoise(1.5F).IsEncoded());
  EXPECT_FLOAT_EQ(MakeNoise(1.5F).coded, 1.5F);
  EXPECT_FLOAT_EQ(MakeNoise(12).coded, 12);
  EXPECT_GT(MakeNoise(0.3F).coded, 3);
  EXPECT_GT(MakeNoise(0.3F).coded, MakeNoise(0.8F).coded);
}

// Rectified images of a recording that no codec touched; motion blur took the noise of the second.
TEST(CodedNoise, DrawingIsNotACodec) {
  ImageNoise drawn = MakeNoise(0.7F);
  drawn.removed_as_taken = 0;
  ImageNoise blurred = MakeNoise(0.3F);
  EXPECT_FALSE(drawn.IsEncoded());
  EXPECT_FALSE(CodecCounts(drawn, drawn, true));
  EXPECT_FALSE(CodecCounts(drawn, blurred, true));
  EXPECT_TRUE(SmoothingCounts(drawn, blurred, true)) << "drawing makes errors";
  EXPECT_FLOAT_EQ(CodedPower(drawn, drawn, true), drawn.coded * drawn.coded);
  EXPECT_FLOAT_EQ(CommonPower(drawn, blurred, true), drawn.coded * drawn.coded) << "not the blur";
  EXPECT_FLOAT_EQ(CommonPower(blurred, blurred, true), blurred.coded * blurred.coded);
}

TEST(CodedNoise, TheLossAsTakenIsThatBeforeDrawing) {
  const cv::Mat taken = SyntheticCeiling().Render(kNoiseSize, {}, 1.2);
  cv::Mat drawn;
  cv::blur(taken, drawn, {3, 3});
  EXPECT_EQ(LossAsTaken(taken), 0);
  EXPECT_GT(LossAsTaken(drawn), 0.3);
}

TEST(CodedNoise, OnlyOneImageWithoutNoiseIsNotACodec) {
  const ImageNoise encoded = MakeNoise(0.3F);
  const ImageNoise sensor = MakeNoise(2);
  EXPECT_FLOAT_EQ(CodedPower(encoded, encoded, true), encoded.coded * encoded.coded);
  EXPECT_FLOAT_EQ(CodedPower(encoded, sensor, true), 0.3F * 2);
  EXPECT_FLOAT_EQ(CodedPower(sensor, encoded, true), 0.3F * 2);
  EXPECT_FLOAT_EQ(WhitePower(encoded, encoded), 0.3F * 0.3F);
}

TEST(CodedNoise, AgainstAMapTheImageAloneCounts) {
  ImageNoise encoded = MakeNoise(0.3F);
  const ImageNoise sensor = MakeNoise(2);
  EXPECT_FALSE(CodecCounts(sensor, encoded, false)) << "a camera may have little noise";
  encoded.predicted = true;
  ImageNoise fine = MakeNoise(0.9F);
  fine.predicted = true;
  EXPECT_TRUE(fine.IsEncoded());
  EXPECT_FALSE(CodecCounts(sensor, fine, false)) << "it needs no help";
  for (const ImageNoise& map : {encoded, sensor}) {
    EXPECT_TRUE(CodecCounts(map, encoded, false));
    EXPECT_FALSE(CodecCounts(map, sensor, false));
    EXPECT_FLOAT_EQ(CodedPower(map, encoded, false), encoded.coded * encoded.coded);
    EXPECT_FLOAT_EQ(CodedPower(map, sensor, false), map.white * 2);
  }
}

TEST(CodedNoise, AReducedImageHasLess) {
  const ImageNoise half = MakeNoise(0.3F).Reduced(2);
  EXPECT_FLOAT_EQ(half.white, 0.15F);
  EXPECT_FLOAT_EQ(half.removed, 0.7F);
}

}  // namespace
}  // namespace ceilmap::registration
