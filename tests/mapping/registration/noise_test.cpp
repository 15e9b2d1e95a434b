#include "mapping/registration/noise.hpp"

#include <gtest/gtest.h>

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
  for (const ImageNoise& map : {encoded, sensor}) {
    EXPECT_TRUE(CodecCounts(map, encoded, false));
    EXPECT_FALSE(CodecCounts(map, sensor, false));
    EXPECT_FLOAT_EQ(CodedPower(map, encoded, false), encoded.coded * encoded.coded);
    EXPECT_FLOAT_EQ(CodedPower(map, sensor, false), map.white * 2);
  }
}

// To draw an image smooths its noise: that is no codec.
TEST(CodedNoise, ARectifiedImageHasTheSensorsNoise) {
  calib::MountedCamera camera;
  camera.camera = calib::Lens::WithoutDistortion(calib::LensModel::kPlumbBob, kNoiseSize, 450);
  EXPECT_EQ(SensorNoiseIn(calib::CeilingView(camera, 2.5)), kSensorNoise);
  camera.camera = calib::Lens::WithoutDistortion(calib::LensModel::kEquidistant, kNoiseSize, 230);
  const calib::CeilingView view(camera, 2.5);
  const float left = SensorNoiseIn(view);
  EXPECT_GT(left, 0.3F);
  EXPECT_LT(left, 0.95F);
  cv::Mat raw(kNoiseSize, CV_8UC1);
  cv::randn(raw, 128, 1.3);
  cv::Mat buffer;
  const float noise = EstimateNoise(view.Rectify(raw, buffer));
  EXPECT_TRUE(MakeNoise(noise).IsEncoded()) << "else this shows nothing";
  EXPECT_FALSE(MakeNoise(noise, left).IsEncoded());
}

TEST(CodedNoise, AReducedImageHasLess) {
  const ImageNoise half = MakeNoise(0.3F).Reduced(2);
  EXPECT_FLOAT_EQ(half.white, 0.15F);
  EXPECT_FLOAT_EQ(half.removed, 0.7F);
}

}  // namespace
}  // namespace ceilmap::registration
