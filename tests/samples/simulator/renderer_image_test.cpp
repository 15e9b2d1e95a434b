#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>
#include <thread>

#include "calib/base/error.hpp"
#include "samples/simulator/ceiling_pattern.hpp"
#include "tests/samples/simulator/scenes.hpp"

namespace ceilmap::simulator {
namespace {

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0;
}

Scene LivelyScene() {
  Scene scene;
  scene.camera.width_px = 320;
  scene.camera.height_px = 240;
  scene.camera.focal_px = 220;
  scene.ceiling.lamp_every_x = 4;
  scene.ceiling.lamp_every_y = 4;
  scene.ceiling.stains_per_100m2 = 50;
  scene.fixtures.sprinklers_per_100m2 = 50;
  scene.fixtures.ducts_per_100m2 = 5;
  return scene;
}

std::pair<double, double> MeanAndDeviation(const cv::Mat& image) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  return {mean[0], deviation[0]};
}

TEST(RendererImage, FrameDependsOnSceneAndIndexOnly) {
  const std::vector<Frame> frames = MakePath(LivelyScene());
  const Renderer one(LivelyScene());
  const Renderer other(LivelyScene());
  const cv::Mat first = one.Render(frames[3]);
  for (const int i : {90, 60, 30}) (void)other.Render(frames[i]);
  EXPECT_TRUE(Same(other.Render(frames[3]), first));
  EXPECT_FALSE(Same(one.Render(frames[4]), first));
}

TEST(RendererImage, ThreadsShareARenderer) {
  const std::vector<Frame> frames = MakePath(LivelyScene());
  const Renderer alone(LivelyScene());
  const Renderer shared(LivelyScene());
  std::vector<cv::Mat> images(16);
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&, t] {
        for (int i = t; i < 16; i += 4) images[i] = shared.Render(frames[5 * i]);
      });
    }
  }
  for (int i = 0; i < 16; ++i) EXPECT_TRUE(Same(images[i], alone.Render(frames[5 * i]))) << i;
}

TEST(RendererImage, AnotherSeedIsAnotherCeiling) {
  Scene scene = LivelyScene();
  scene.image.shot_noise = 0;
  scene.image.read_noise = 0;
  scene.image.gain_spread = 0;
  const cv::Mat first = Renderer(scene).Render(StillFrame(0, {6, 4, 0}));
  scene.seed = 2;
  EXPECT_GT(cv::norm(first, Renderer(scene).Render(StillFrame(0, {6, 4, 0})), cv::NORM_L1),
            first.total());
}

TEST(RendererImage, GreyFollowsTheSrgbCurve) {
  Scene scene = PlainScene();
  scene.ceiling.brightness = 0.2140411;  // sRGB 0.5
  const cv::Mat image = Renderer(scene).Render(StillFrame(0, {6, 4, 0}));
  EXPECT_EQ(image.type(), CV_8UC1);
  const auto [mean, deviation] = MeanAndDeviation(image);
  EXPECT_NEAR(mean, 127.5, 0.51);
  EXPECT_EQ(deviation, 0);
}

TEST(RendererImage, ExposureStepsHoldUntilTheNext) {
  Scene scene = PlainScene();
  scene.ceiling.brightness = 0.1;
  scene.image.exposure_gain = 2;
  scene.image.exposure_steps = {{5, 0.5}, {7, 2.0}};
  const Renderer renderer(scene);
  const auto grey = [&](int index) {
    return static_cast<int>(renderer.Render(StillFrame(index, {6, 4, 0})).at<std::uint8_t>(9, 9));
  };
  EXPECT_EQ(grey(4), 124);  // sRGB of 0.2
  EXPECT_EQ(grey(5), 89);   // of 0.1
  EXPECT_EQ(grey(6), 89);
  EXPECT_EQ(grey(7), 170);  // of 0.4
}

TEST(RendererImage, InTheDarkThereIsOnlyNoise) {
  Scene scene = LivelyScene();
  scene.forward = DefaultForwardCamera();
  scene.omni.emplace();
  const Frame lit = StillFrame(7, {6, 4, 0}, 104.99);
  const Frame dark = StillFrame(8, {6, 4, 0}, 105);
  const cv::Mat before = Renderer(scene).Render(lit);
  scene.image.dark = {{5, 7.5}};
  const Renderer renderer(scene);
  EXPECT_TRUE(Same(renderer.Render(lit), before));
  EXPECT_GT(MeanAndDeviation(renderer.RenderForward(lit)).first, 20);
  EXPECT_LT(MeanAndDeviation(renderer.RenderForward(dark)).first, 2);
  EXPECT_LT(MeanAndDeviation(renderer.RenderOmni(dark)).first, 2);
  const cv::Mat black = renderer.Render(dark);
  const auto [mean, deviation] = MeanAndDeviation(black);
  EXPECT_LT(mean, 2);
  EXPECT_GT(deviation, 0.2);
  // It does not depend on the place: nothing of the room is left.
  EXPECT_TRUE(Same(black, renderer.Render(StillFrame(8, {3, 2, 1}, 107.5))));
  EXPECT_FALSE(Same(black, renderer.Render(StillFrame(9, {6, 4, 0}, 106))));
  EXPECT_GT(MeanAndDeviation(renderer.Render(StillFrame(9, {6, 4, 0}, 107.51))).first, 20);
}

TEST(RendererImage, VignettingDarkensTheCornersByItsShare) {
  Scene scene = PlainScene();
  scene.image.vignetting = 0.5;
  const cv::Mat image = Renderer(scene).Render(StillFrame(0, {6, 4, 0}));
  EXPECT_EQ(image.at<std::uint8_t>(119, 159), 170);  // 0.4
  EXPECT_EQ(image.at<std::uint8_t>(0, 0), 124);      // 0.2
}

TEST(RendererImage, NoiseHasItsDeviation) {
  Scene scene = PlainScene();
  scene.image.shot_noise = 0.02;
  const Renderer renderer(scene);
  const auto [mean, deviation] = MeanAndDeviation(renderer.Render(StillFrame(0, {6, 4, 0})));
  // 0.02 sqrt(0.4) of light, times the curve's slope 1.055 / 2.4 * 0.4^(1/2.4 - 1) * 255 grey
  // levels, and the rounding to whole ones.
  const double slope = 255 * 1.055 / 2.4 * std::pow(0.4, 1 / 2.4 - 1);
  EXPECT_NEAR(deviation, std::hypot(0.02 * std::sqrt(0.4) * slope, std::sqrt(1 / 12.0)), 0.05);
  EXPECT_NEAR(mean, 169.6, 0.1);
  const cv::Mat a = renderer.Render(StillFrame(1, {6, 4, 0}));
  const cv::Mat b = renderer.Render(StillFrame(2, {6, 4, 0}));
  cv::Mat difference;
  cv::subtract(a, b, difference, cv::noArray(), CV_32F);
  EXPECT_NEAR(MeanAndDeviation(difference).second, std::sqrt(2.0) * deviation, 0.05);
}

TEST(RendererImage, MotionBlurSpreadsAlongTheMotionOnly) {
  Scene scene = PlainScene();
  scene.image.motion_blur = true;
  scene.ceiling.brightness = 0.05;
  scene.ceiling.marks_at = {{6, 4, 0.03, 0.9}};
  const Renderer renderer(scene);
  for (const double blur_px : {1.0, 6.0}) {
    Frame frame = StillFrame(0, {6, 4, 0});
    frame.T_map_base_open = Level(6 - blur_px / 2 / 200, 4, 0);
    frame.T_map_base_close = Level(6 + blur_px / 2 / 200, 4, 0);
    cv::Mat still;
    cv::Mat moving;
    // Back to light: about, that is enough here.
    const auto light_of = [&](const Frame& f, cv::Mat& light) {
      renderer.Render(f).convertTo(light, CV_32F, 1 / 255.0);
      cv::pow(light, 2.2, light);
      light -= light.at<float>(0, 0);
    };
    light_of(StillFrame(0, {6, 4, 0}), still);
    light_of(frame, moving);
    const cv::Moments s = cv::moments(still);
    const cv::Moments m = cv::moments(moving);
    EXPECT_NEAR(m.m10 / m.m00, 159.5, 0.02);
    EXPECT_NEAR(m.m01 / m.m00, 119.5, 0.02);
    EXPECT_NEAR(m.mu20 / m.m00, s.mu20 / s.m00, 0.15);
    // The square of a box's width, by 12.
    EXPECT_NEAR(m.mu02 / m.m00 - s.mu02 / s.m00, blur_px * blur_px / 12, 0.15);
  }
}

TEST(CeilingPattern, PeriodicCeilingRepeatsBitByBit) {
  Scene scene;
  scene.ceiling.kind = CeilingKind::kPeriodic;
  scene.ceiling.tile_length_m = 0.6;
  scene.ceiling.tile_width_m = 0.45;
  const CeilingPattern pattern(scene, 0.0041);
  const auto columns = static_cast<int>(std::lround(0.6 / pattern.PitchX()));
  const auto rows = static_cast<int>(std::lround(0.45 / pattern.PitchY()));
  EXPECT_DOUBLE_EQ(columns * pattern.PitchX(), 0.6);
  const cv::Mat here = pattern.Sample(31, 17, 200, 180);
  EXPECT_TRUE(Same(here, pattern.Sample(31 + 7 * columns, 17 - 30 * rows, 200, 180)));
  EXPECT_FALSE(Same(here, pattern.Sample(32, 17, 200, 180)));
}

TEST(CeilingPattern, LampsOfAPeriodicCeilingMultiplyThePeriod) {
  Scene scene;
  scene.ceiling.kind = CeilingKind::kPeriodic;
  scene.ceiling.lamp_every_x = 3;
  scene.ceiling.lamp_every_y = 2;
  const CeilingPattern pattern(scene, 0.01);  // 60 samples a tile
  const cv::Mat here = pattern.Sample(0, 0, 360, 240);
  EXPECT_TRUE(Same(here, pattern.Sample(180, -240, 360, 240)));
  EXPECT_FALSE(Same(here, pattern.Sample(60, 0, 360, 240)));
  EXPECT_FLOAT_EQ(here.at<float>(30, 30), 2.5F);
  EXPECT_LT(here.at<float>(90, 30), 0.6F);
}

TEST(CeilingPattern, TilesDiffer) {
  const CeilingPattern pattern(Scene(), 0.01);
  EXPECT_GT(cv::norm(pattern.Sample(0, 0, 60, 60), pattern.Sample(60, 0, 60, 60), cv::NORM_L1),
            0.005 * 3600);
}

TEST(CeilingPattern, PlasterIsWeakAndWithoutEnd) {
  Scene scene;
  scene.ceiling.kind = CeilingKind::kPlaster;
  scene.ceiling.speckle_contrast = 0.02;
  scene.ceiling.light_contrast = 0;
  const CeilingPattern pattern(scene, 0.005);
  const cv::Mat all = pattern.Sample(-1000, 4000, 1000, 1000);
  EXPECT_TRUE(Same(all(cv::Rect(300, 200, 100, 100)), pattern.Sample(-700, 4200, 100, 100)));
  const auto [mean, deviation] = MeanAndDeviation(all);
  EXPECT_NEAR(mean, 0.4, 0.004);
  EXPECT_NEAR(deviation, 0.4 * 0.02, 0.4 * 0.004);
}

TEST(CeilingPattern, PlainPartsHideTheTextureAndNothingElse) {
  Scene scene;
  scene.ceiling.stains_per_100m2 = 50;
  const cv::Mat textured = CeilingPattern(scene, 0.01).Sample(0, 0, 600, 400);
  scene.ceiling.plain = {{3, 2, 1.005, 2}};
  scene.ceiling.marks_at = {{3.2, 2.2, 0.1, 0.7}};
  const cv::Mat light = CeilingPattern(scene, 0.01).Sample(0, 0, 600, 400);
  // x from 2.4975 to 3.5025 m, y from 1 to 3 m.
  const cv::Rect inside(250, 100, 100, 200);
  cv::Mat outside(light.size(), CV_8UC1, cv::Scalar(255));
  outside(cv::Rect(249, 99, 102, 202)).setTo(0);
  EXPECT_EQ(cv::norm(light, textured, cv::NORM_INF, outside), 0);
  EXPECT_FLOAT_EQ(light.at<float>(220, 320), 0.7F);
  cv::Mat plain = light(inside).clone();
  plain(cv::Rect(55, 105, 30, 30)).setTo(0.4F);  // the mark
  EXPECT_NEAR(cv::norm(plain, cv::Mat(plain.size(), CV_32FC1, 0.4F), cv::NORM_INF), 0, 1e-6);
  const float before = textured.at<float>(200, 249);  // a quarter of the sample is covered
  EXPECT_NEAR(light.at<float>(200, 249), before + 0.25F * (0.4F - before), 1e-4);
}

TEST(CeilingPattern, JointHasItsWidth) {
  Scene scene;
  scene.ceiling.kind = CeilingKind::kPeriodic;
  scene.ceiling.speckle_contrast = 0;
  scene.ceiling.joint_m = 0.0137;
  scene.ceiling.joint_contrast = 1;  // black
  scene.ceiling.brightness = 1;
  const CeilingPattern pattern(scene, 0.005);
  const cv::Mat joint = pattern.Sample(60, 60, 120, 1);  // across the joint at x = 0.6
  // The tile's edge is beveled, so compare with the shares of the samples beside the joint: the
  // second sample from the middle is 0.0137 / 2 - 0.005 m covered.
  EXPECT_EQ(joint.at<float>(0, 60), 0);
  EXPECT_NEAR(joint.at<float>(0, 61) / joint.at<float>(0, 62), 1 - (0.00685 - 0.005) / 0.005, 0.05);
}

}  // namespace
}  // namespace ceilmap::simulator
