#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

/// The light of 8 bit sRGB.
double Light(double grey) {
  const double c = grey / 255;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double RowLight(const cv::Mat& image, int row) {
  return Light(image.at<std::uint8_t>(row, image.cols / 2));
}

Scene FlickeringScene() {
  Scene scene = PlainScene();
  scene.image.flicker_hz = 120;
  scene.image.flicker_depth = 0.3;
  scene.camera.exposure_time_s = 0.003;
  scene.path.start_stamp_s = 0;
  return scene;
}

/// What is left of the sine in an exposure of 3 ms at 120 Hz: sin(x) / x, x = pi 120 0.003.
constexpr double kLeft = 0.80020;
constexpr double kOneGrey = 0.005;  // of light 0.4, and its rounding

TEST(Flicker, RollingShutterShowsBandsOfItsReadOut) {
  Scene scene = FlickeringScene();
  scene.camera.readout_time_s = 0.025;  // three periods from the first row to the last
  const double stamp_s = 0.7;           // 84 periods: the middle row's light is its mean
  const cv::Mat image = Renderer(scene).Render(StillFrame(0, {6, 4, 0}, stamp_s));
  for (const int row : {0, 20, 50, 100, 119, 170, 239}) {
    const double phase = 2 * std::numbers::pi * 3 * (row / 239.0 - 0.5);
    EXPECT_NEAR(RowLight(image, row), 0.4 * (1 + 0.3 * kLeft * std::sin(phase)), kOneGrey) << row;
  }
  scene.camera.readout_time_s = -0.025;
  const cv::Mat upwards = Renderer(scene).Render(StillFrame(0, {6, 4, 0}, stamp_s));
  for (const int row : {20, 100, 170}) {
    EXPECT_NEAR(RowLight(upwards, row), RowLight(image, 239 - row), kOneGrey) << row;
  }
}

TEST(Flicker, WithoutReadOutTheWholeImageChanges) {
  const Renderer renderer(FlickeringScene());
  const cv::Mat brightest = renderer.Render(StillFrame(0, {6, 4, 0}, 1.0 / 120 / 4));
  EXPECT_EQ(brightest.at<std::uint8_t>(0, 0), brightest.at<std::uint8_t>(239, 319));
  EXPECT_NEAR(RowLight(brightest, 5), 0.4 * (1 + 0.3 * kLeft), kOneGrey);
  const cv::Mat darkest = renderer.Render(StillFrame(0, {6, 4, 0}, 3.0 / 120 / 4));
  EXPECT_NEAR(RowLight(darkest, 5), 0.4 * (1 - 0.3 * kLeft), kOneGrey);
}

TEST(Flicker, ExposureOfAWholePeriodShowsNone) {
  Scene scene = FlickeringScene();
  scene.camera.exposure_time_s = 1.0 / 120;
  scene.camera.readout_time_s = 0.025;
  const cv::Mat image = Renderer(scene).Render(StillFrame(0, {6, 4, 0}, 0.4021));
  for (const int row : {0, 30, 90, 200}) EXPECT_NEAR(RowLight(image, row), 0.4, kOneGrey);
}

TEST(WhiteBalance, DriftsApartInColourOnly) {
  Scene scene = DarkScene();
  scene.room.floor_brightness = 0.4;
  scene.room.wall_brightness = 0.4;
  scene.image.white_balance_drift = 0.2;
  scene.image.exposure_period_s = 40;
  scene.path.start_stamp_s = 0;
  Camera& forward = scene.forward.emplace(DefaultForwardCamera());
  forward.saturation = 1;
  const Renderer renderer(scene);
  const Frame neutral = StillFrame(0, {2, 4, 0}, 0);
  const Frame warm = StillFrame(0, {2, 4, 0}, 10);  // a quarter of the period
  const cv::Vec3b before = renderer.RenderForward(neutral).at<cv::Vec3b>(240, 320);
  const cv::Vec3b after = renderer.RenderForward(warm).at<cv::Vec3b>(240, 320);
  EXPECT_NEAR(Light(after[0]) / Light(before[0]), 0.8, 0.02);
  EXPECT_EQ(after[1], before[1]);
  EXPECT_NEAR(Light(after[2]) / Light(before[2]), 1.2, 0.02);
  EXPECT_EQ(cv::norm(renderer.Render(neutral), renderer.Render(warm), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace ceilmap::simulator
