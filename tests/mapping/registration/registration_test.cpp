#include "mapping/registration/registration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {
namespace {

ImageMotion RandomImageMotion(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {200 * unit(random),
          200 * unit(random),
          std::numbers::pi * unit(random),
          std::exp(unit(random))};
}

TEST(ImageMotion, SignsByHand) {
  // A quarter turn takes the content at the right (u) to the bottom (v): clockwise on the screen.
  const ImageMotion motion{5, -2, std::numbers::pi / 2, 2};
  EXPECT_LT((motion.Apply({10, 0}) - Eigen::Vector2d(5, 18)).norm(), 1e-12);
  EXPECT_LT((motion.Apply({0, 10}) - Eigen::Vector2d(-15, -2)).norm(), 1e-12);
  EXPECT_LT((ImageMotion{}.Apply({3, 4}) - Eigen::Vector2d(3, 4)).norm(), 1e-15);
}

TEST(ImageMotion, InverseUndoes) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const ImageMotion motion = RandomImageMotion(random);
    const Eigen::Vector2d x(13.0 * i - 600, 400 - 7.0 * i);
    EXPECT_LT((motion.Inverse().Apply(motion.Apply(x)) - x).norm(), 1e-9);
    EXPECT_LT((motion.Apply(motion.Inverse().Apply(x)) - x).norm(), 1e-9);
  }
}

TEST(ImageMotion, ComposeIsOneAfterTheOther) {
  std::mt19937 random(2);
  for (int i = 0; i < 100; ++i) {
    const ImageMotion first = RandomImageMotion(random);
    const ImageMotion second = RandomImageMotion(random);
    const ImageMotion both = Compose(second, first);
    const Eigen::Vector2d x(13.0 * i - 600, 400 - 7.0 * i);
    EXPECT_LT((both.Apply(x) - second.Apply(first.Apply(x))).norm(), 1e-9);
    EXPECT_GT(both.theta_rad, -std::numbers::pi);
    EXPECT_LE(both.theta_rad, std::numbers::pi);
  }
}

TEST(ImageMotion, InverseOfAHalfTurnStaysInRange) {
  EXPECT_EQ((ImageMotion{0, 0, std::numbers::pi, 1}.Inverse().theta_rad), std::numbers::pi);
}

TEST(OverlapOf, ByHand) {
  const cv::Size size(640, 480);
  EXPECT_EQ(OverlapOf({}, size), 1);
  EXPECT_NEAR(OverlapOf({160, 0, 0, 1}, size), 0.75, 0.01);
  EXPECT_NEAR(OverlapOf({320, -240, 0, 1}, size), 0.25, 0.01);
  EXPECT_EQ(OverlapOf({640, 0, 0, 1}, size), 0);
  EXPECT_EQ(OverlapOf({0, -500, 0, 1}, size), 0);
  EXPECT_EQ(OverlapOf({0, 0, std::numbers::pi, 1}, size), 1);
  EXPECT_NEAR(OverlapOf({0, 0, std::numbers::pi / 2, 1}, size), 0.75, 0.02);
  EXPECT_NEAR(OverlapOf({0, 0, 0, 2}, size), 0.25, 0.01) << "twice as large, half of it in view";
  EXPECT_EQ(OverlapOf({0, 0, 0, 0.5}, size), 1) << "all of the reference is seen";
}

TEST(OverlapOf, AgreesWithAFineGrid) {
  const cv::Size size(640, 480);
  std::mt19937 random(3);
  for (int i = 0; i < 60; ++i) {
    ImageMotion motion = RandomImageMotion(random);
    motion.scale = std::sqrt(motion.scale);
    constexpr int kSteps = 320;
    int seen = 0;
    for (int y = 0; y < kSteps; ++y) {
      for (int x = 0; x < kSteps; ++x) {
        const Eigen::Vector2d p =
            motion.Apply({((x + 0.5) / kSteps - 0.5) * 640, ((y + 0.5) / kSteps - 0.5) * 480});
        if (std::abs(p.x()) < 320 && std::abs(p.y()) < 240) ++seen;
      }
    }
    EXPECT_NEAR(OverlapOf(motion, size), static_cast<double>(seen) / (kSteps * kSteps), 0.015) << i;
  }
}

TEST(Verdict, Names) {
  EXPECT_STREQ(ToString(Verdict::kOk), "ok");
  EXPECT_STREQ(ToString(Verdict::kNoTexture), "no texture");
  EXPECT_STREQ(ToString(Verdict::kNoMatch), "no match");
  EXPECT_STREQ(ToString(Verdict::kAmbiguous), "ambiguous");
}

}  // namespace
}  // namespace ceilmap::registration
