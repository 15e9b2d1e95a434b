#include "samples/simulator/auto_exposure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

/// Stands still at ten frames a second in a room whose light goes to 0.25 at frame 5.
Scene DimmedScene() {
  Scene scene = PlainScene();
  scene.image.exposure_steps = {{5, 0.25}};
  scene.image.auto_exposure_lag_s = 0.5;
  return scene;
}

std::vector<Frame> StillFrames(const Scene& scene, int count) {
  std::vector<Frame> frames;
  for (int i = 0; i < count; ++i) frames.push_back(StillFrame(i, {6, 4, 0}, 0.1 * i));
  FollowExposure(scene, frames);
  return frames;
}

TEST(AutoExposure, FollowsWithItsLag) {
  const std::vector<Frame> frames = StillFrames(DimmedScene(), 60);
  for (int i = 0; i <= 5; ++i) EXPECT_NEAR(frames[i].auto_gain, 1, 1e-6) << i;
  // What is missing in log gain falls by exp(-1) in 0.5 s.
  EXPECT_NEAR(std::log(frames[10].auto_gain), std::log(4) * (1 - std::exp(-1)), 0.01);
  EXPECT_NEAR(std::log(frames[15].auto_gain), std::log(4) * (1 - std::exp(-2)), 0.01);
  EXPECT_NEAR(frames.back().auto_gain, 4, 0.01);
  const Renderer renderer(DimmedScene());
  EXPECT_NEAR(renderer.Render(frames.back()).at<std::uint8_t>(9, 9),
              renderer.Render(frames.front()).at<std::uint8_t>(9, 9),
              1);
}

TEST(AutoExposure, WithoutItTheFramesRemain) {
  Scene scene = DimmedScene();
  scene.image.auto_exposure_lag_s = 0;
  for (const Frame& frame : StillFrames(scene, 20)) EXPECT_EQ(frame.auto_gain, 1);
}

TEST(AutoExposure, IsOfTheUpwardCameraOnly) {
  Scene scene = PlainScene();
  scene.forward = DefaultForwardCamera();
  const Renderer renderer(scene);
  Frame frame = StillFrame(0, {6, 4, 0});
  const cv::Mat up = renderer.Render(frame);
  const cv::Mat forward = renderer.RenderForward(frame);
  frame.auto_gain = 0.5;
  EXPECT_EQ(renderer.Render(frame).at<std::uint8_t>(9, 9), 124);  // sRGB of 0.2
  EXPECT_EQ(cv::norm(renderer.RenderForward(frame), forward, cv::NORM_INF), 0);
}

TEST(AutoExposure, DarkensWhereLampsComeIntoView) {
  Scene scene = PlainScene();
  scene.fixtures.boxes = {{9, 4, 1, 1, 2.3, 2.39, 0, 3}};
  scene.image.auto_exposure_lag_s = 0.1;
  std::vector<Frame> frames;
  for (int i = 0; i < 30; ++i) frames.push_back(StillFrame(i, {3 + 0.2 * i, 4, 0}, 0.1 * i));
  FollowExposure(scene, frames);
  EXPECT_NEAR(frames[5].auto_gain, 1, 1e-6);
  EXPECT_LT(frames.back().auto_gain, 0.8);
}

}  // namespace
}  // namespace ceilmap::simulator
