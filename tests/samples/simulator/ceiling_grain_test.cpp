// The grain of a ceiling belongs to the ceiling: it is the same in every image.

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "samples/simulator/ceiling_pattern.hpp"
#include "samples/simulator/noise.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

double Correlation(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat result;
  cv::matchTemplate(a, b, result, cv::TM_CCOEFF_NORMED);
  return result.at<float>(0, 0);
}

double Deviation(const cv::Mat& samples) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(samples, mean, deviation);
  return deviation[0];
}

cv::Mat Shrunk(const cv::Mat& image, int times) {
  cv::Mat small;
  cv::resize(image, small, image.size() / times, 0, 0, cv::INTER_AREA);
  return small;
}

// Grain of this size in metres, from x = y = 0.
cv::Mat Grain(double pitch_m, double size_m) {
  const int count = static_cast<int>(std::lround(size_m / pitch_m));
  cv::Mat samples(count, count, CV_32FC1, cv::Scalar(0));
  AddGrain(42, {0, 0, pitch_m, pitch_m, count, count}, samples);
  return samples;
}

// Nothing but the grain of one large tile, seen from 2 m below at 5 mm a pixel.
Scene GrainyScene() {
  Scene scene = PlainScene();
  scene.ceiling.kind = CeilingKind::kTiles;
  scene.ceiling.tile_length_m = 12;
  scene.ceiling.tile_width_m = 8;
  scene.ceiling.tile_contrast = 0;
  scene.ceiling.light_contrast = 0;
  scene.ceiling.stains_per_100m2 = 0;
  scene.ceiling.vents_per_100m2 = 0;
  return scene;
}

cv::Mat Seen(const Scene& scene) {
  return Renderer(scene).RenderLight(Level(5.003, 3.001, 20));
}

TEST(CeilingGrain, IsTheSameThroughAnotherLens) {
  Scene scene = GrainyScene();
  const cv::Mat coarse = Seen(scene);
  EXPECT_GT(Deviation(coarse), 0.01 * 0.4);
  scene.camera.width_px *= 2;
  scene.camera.height_px *= 2;
  scene.camera.focal_px *= 2;
  EXPECT_GT(Correlation(Shrunk(Seen(scene), 2), coarse), 0.98);
  scene.camera.width_px = 3 * 320;
  scene.camera.height_px = 3 * 240;
  scene.camera.focal_px = 3 * 400;
  EXPECT_GT(Correlation(Shrunk(Seen(scene), 3), coarse), 0.97);
}

TEST(CeilingGrain, IsTheSameFromAnotherHeight) {
  Scene scene = GrainyScene();
  const cv::Mat low = Seen(scene);
  scene.camera.mount_height_m = 1.4;  // half as far from the ceiling
  scene.camera.width_px *= 2;
  scene.camera.height_px *= 2;
  EXPECT_GT(Correlation(Shrunk(Seen(scene), 2), low), 0.98);
}

TEST(CeilingGrain, OfAPeriodicCeilingIsTheSameToo) {
  Scene scene = GrainyScene();
  scene.ceiling.kind = CeilingKind::kPeriodic;
  const cv::Mat coarse = Seen(scene);
  scene.camera.width_px *= 2;
  scene.camera.height_px *= 2;
  scene.camera.focal_px *= 2;
  EXPECT_GT(Correlation(Shrunk(Seen(scene), 2), coarse), 0.98);
}

// A camera that turns by 90 degrees over a tile's middle or corner has the same image.
TEST(CeilingGrain, OfASymmetricTileIsItsOwnAfterAQuarterTurn) {
  Scene scene = PlainScene();
  scene.camera.height_px = scene.camera.width_px;
  scene.ceiling.kind = CeilingKind::kPeriodic;
  const auto seen = [&](double yaw_deg) {
    return Renderer(scene).RenderLight(Level(5.1, 3.3, yaw_deg));  // a tile's middle
  };
  EXPECT_LT(Correlation(seen(90), seen(0)), 0.9);
  const double deviation = Deviation(seen(0));
  scene.ceiling.symmetric = true;
  for (const double turn_deg : {90, 180, 270}) {
    EXPECT_LT(cv::norm(seen(turn_deg), seen(0), cv::NORM_INF), 1e-3) << turn_deg;
  }
  EXPECT_GT(cv::norm(seen(45), seen(0), cv::NORM_INF), 0.05);
  EXPECT_NEAR(Deviation(seen(0)) / deviation, 1, 0.2);  // as rich as the other
}

TEST(CeilingGrain, OfASymmetricTileIsTheSameInEveryPart) {
  Scene scene;
  scene.ceiling.kind = CeilingKind::kPeriodic;
  scene.ceiling.symmetric = true;
  const CeilingPattern pattern(scene, 0.005);
  const cv::Mat whole = pattern.Sample(0, 0, 240, 240);
  const cv::Mat part = pattern.Sample(17, 131, 90, 50);
  EXPECT_LT(cv::norm(part, whole(cv::Rect(17, 131, 90, 50)), cv::NORM_INF), 1e-5);
  cv::Mat turned;
  cv::rotate(whole, turned, cv::ROTATE_90_CLOCKWISE);
  EXPECT_LT(cv::norm(turned, whole, cv::NORM_INF), 1e-5);
}

TEST(AddGrain, HasDeviationOneInSamplesOf4mm) {
  const cv::Mat grain = Grain(0.004, 4);
  EXPECT_NEAR(Deviation(grain), 1, 0.03);
  EXPECT_NEAR(cv::mean(grain)[0], 0, 0.03);
}

// What finer samples show beyond the reach of coarser ones must not come back as false patterns.
TEST(AddGrain, CoarseSamplesShowTheMeanOfFineOnes) {
  const cv::Mat fine = Grain(0.001, 2.4);
  for (const int times : {2, 4, 8, 12}) {
    const cv::Mat coarse = Grain(0.001 * times, 2.4);
    EXPECT_GT(Correlation(Shrunk(fine, times), coarse), 0.9) << times;
    EXPECT_LT(Deviation(coarse), 1.02 * Deviation(Shrunk(fine, times))) << times;
  }
}

TEST(AddGrain, FadesAwayInVeryCoarseSamples) {
  EXPECT_LT(Deviation(Grain(0.03, 6)), 0.15);
  EXPECT_EQ(Deviation(Grain(0.04, 6)), 0);
}

TEST(AddGrain, OfAPlaceIsTheSameInWhateverGrid) {
  const cv::Mat all = Grain(0.004, 2);
  cv::Mat part(90, 70, CV_32FC1, cv::Scalar(0));
  AddGrain(42, {131, 257, 0.004, 0.004, 70, 90}, part);
  EXPECT_EQ(cv::norm(part, all(cv::Rect(131, 257, 70, 90)), cv::NORM_INF), 0);
}

TEST(CeilingPattern, TilesHaveGrainsOfTheirOwn) {
  Scene scene = GrainyScene();
  scene.ceiling.tile_length_m = 1;
  scene.ceiling.tile_width_m = 1;
  const CeilingPattern pattern(scene, 0.004);
  const cv::Mat one = pattern.Sample(20, 20, 210, 210);
  const cv::Mat next = pattern.Sample(270, 20, 210, 210);
  EXPECT_LT(std::abs(Correlation(one, next)), 0.1);
}

TEST(CeilingPattern, NoTileOfOneSeedIsATileOfTheNext) {
  Scene scene = GrainyScene();
  scene.ceiling.tile_length_m = 1;
  scene.ceiling.tile_width_m = 1;
  const CeilingPattern pattern(scene, 0.01);
  ++scene.seed;
  const CeilingPattern other(scene, 0.01);
  const cv::Mat tile = pattern.Sample(100 * 5 + 5, 100 * 2 + 5, 90, 90);
  for (int column = 0; column < 10; ++column) {
    for (int row = 0; row < 6; ++row) {
      const cv::Mat there = other.Sample(100 * column + 5, 100 * row + 5, 90, 90);
      EXPECT_LT(std::abs(Correlation(tile, there)), 0.3) << column << ' ' << row;
    }
  }
}

}  // namespace
}  // namespace ceilmap::simulator
