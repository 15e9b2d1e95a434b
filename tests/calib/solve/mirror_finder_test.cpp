#include "calib/solve/mirror_finder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>

#include "calib/solve/circle_fit.hpp"
#include "calib/solve/radial_edges.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::Vector2d;

const Vector2d kCentre(161.3, 118.6);
constexpr double kRim = 104.4;
constexpr double kBody = 24.7;

double ToGrey(double light) {
  const double v = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
  return 255 * std::clamp(v, 0.0, 1.0);
}

/// Light of the room in a direction, before the camera's limits: bright and dark sectors, one of
/// them far too bright, rings of the floor.
double RoomLight(double azimuth, double radius) {
  const double stripes = std::sin(7 * azimuth) + 0.6 * std::sin(13 * azimuth + 1);
  const double window = std::cos(azimuth) > 0.95 ? 3 : 0;
  return 0.18 + 0.07 * stripes + window + 0.03 * std::sin(radius / 9 + 3 * azimuth);
}

struct Sketch {
  bool square_body = false;
  double noise = 1;
};

/// The mirror when the robot has turned so far: a body that stays, a room that turns, nothing
/// outside. Edges have their share of each pixel.
cv::Mat MirrorImage(double turn_rad, const Sketch& sketch, std::mt19937& random) {
  constexpr int kFine = 4;
  std::normal_distribution<double> noise(0, sketch.noise);
  cv::Mat light(240 * kFine, 320 * kFine, CV_32FC1);
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) {
      const Vector2d at = Vector2d(u + 0.5, v + 0.5) / kFine - Vector2d(0.5, 0.5) - kCentre;
      const double radius = at.norm();
      const double size = sketch.square_body ? at.cwiseAbs().maxCoeff() : radius;
      double value = 0.02;
      if (radius < kRim) value = RoomLight(std::atan2(at.y(), at.x()) + turn_rad, radius);
      if (size < kBody) value = 0.15;
      light.at<float>(v, u) = static_cast<float>(value);
    }
  }
  cv::resize(light, light, {320, 240}, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(light, light, {}, 0.6);
  cv::Mat image(light.size(), CV_8UC1);
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) {
      image.at<std::uint8_t>(v, u) =
          cv::saturate_cast<std::uint8_t>(ToGrey(light.at<float>(v, u)) + noise(random));
    }
  }
  return image;
}

MirrorActivity Turn(double by_rad, const Sketch& sketch = {}) {
  constexpr int kImages = 24;
  std::mt19937 random(3);
  MirrorActivity activity;
  for (int i = 0; i < kImages; ++i) {
    activity.Add(MirrorImage(by_rad * i / kImages, sketch, random));
  }
  return activity;
}

TEST(MirrorFinder, FindsTheRingOfATurningRobot) {
  const MirrorRingFit fit = FindRing(Turn(2 * std::numbers::pi));
  ASSERT_EQ(fit.fault, MirrorFault::kNone);
  EXPECT_LT((fit.ring.centre_px - kCentre).norm(), 0.1);
  EXPECT_NEAR(fit.ring.outer_radius_px, kRim, 0.1);
  EXPECT_NEAR(fit.ring.inner_radius_px, kBody, 0.5);
  EXPECT_TRUE(fit.body_seen);
  EXPECT_TRUE(fit.round_body);
  EXPECT_GT(fit.rim_ratio, 0.8);
  EXPECT_LT(fit.outer_sigma_px, 0.15);
}

TEST(MirrorFinder, TheInnerCircleLeavesOutABodyThatIsNotRound) {
  const MirrorRingFit fit = FindRing(Turn(2 * std::numbers::pi, {.square_body = true}));
  ASSERT_EQ(fit.fault, MirrorFault::kNone);
  EXPECT_FALSE(fit.round_body);
  EXPECT_NEAR(fit.ring.inner_radius_px, std::numbers::sqrt2 * kBody, 1);
}

TEST(MirrorFinder, ColourIsTakenToo) {
  std::mt19937 random(3);
  MirrorActivity activity;
  for (int i = 0; i < 12; ++i) {
    cv::Mat colour;
    cv::cvtColor(MirrorImage(0.5 * i, {}, random), colour, cv::COLOR_GRAY2BGR);
    activity.Add(colour);
  }
  const MirrorRingFit fit = FindRing(activity);
  ASSERT_EQ(fit.fault, MirrorFault::kNone);
  EXPECT_LT((fit.ring.centre_px - kCentre).norm(), 0.2);
}

TEST(MirrorFinder, NothingMoves) {
  EXPECT_EQ(FindRing(Turn(0)).fault, MirrorFault::kNothingMoves);
  EXPECT_EQ(FindRing(MirrorActivity()).fault, MirrorFault::kNothingMoves);
}

TEST(MirrorFinder, WhatMovesIsNotRound) {
  MirrorActivity activity;
  for (int i = 0; i < 12; ++i) {
    cv::Mat image(240, 320, CV_8UC1, cv::Scalar(10));
    cv::rectangle(image, {40, 60, 240, 60}, cv::Scalar(20 * i), cv::FILLED);
    activity.Add(image);
  }
  EXPECT_EQ(FindRing(activity).fault, MirrorFault::kNoRim);
}

TEST(MirrorFinder, OneImageGivesARoughResult) {
  std::mt19937 random(3);
  const MirrorRingFit fit = FindRing(MirrorImage(1, {}, random));
  ASSERT_EQ(fit.fault, MirrorFault::kNone);
  EXPECT_LT((fit.ring.centre_px - kCentre).norm(), 1);
  EXPECT_NEAR(fit.ring.outer_radius_px, kRim, 1);
  EXPECT_EQ(FindRing(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90))).fault, MirrorFault::kNoRim);
  EXPECT_NEAR(fit.outer_sigma_px, 0.01 * fit.ring.outer_radius_px, 0.5)
      << "the reported sigma agrees";
  EXPECT_GT(std::sqrt(fit.centre_covariance(0, 0)), 1);
}

TEST(RadialEdges, ACircleOutsideTheImageHasNone) {
  const cv::Mat map(48, 64, CV_32F, cv::Scalar(1));
  for (const Eigen::Vector2d& centre : {Eigen::Vector2d(-5, 20), Eigen::Vector2d(30, 48)}) {
    EXPECT_TRUE(FirstRisingEdges(map, {centre, 20}, 0.5).empty());
  }
}

TEST(CircleFit, FindsACircleAmongOtherPoints) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.2);
  std::uniform_real_distribution<double> anywhere(0, 200);
  std::vector<Vector2d> points;
  for (int i = 0; i < 180; ++i) {
    const double angle = i * std::numbers::pi / 90;
    points.emplace_back(100 + 60 * std::cos(angle) + noise(random),
                        90 + 60 * std::sin(angle) + noise(random));
    if (i % 3 == 0) points.emplace_back(anywhere(random), anywhere(random));
  }
  const auto found = FindCircle(points, 1);
  ASSERT_TRUE(found);
  const auto fit = FitCircle(points, *found);
  ASSERT_TRUE(fit);
  const double sigma = std::sqrt(fit->covariance(2, 2));
  EXPECT_NEAR(fit->circle.radius, 60, 4 * sigma);
  EXPECT_LT((fit->circle.centre - Vector2d(100, 90)).norm(), 0.1);
  EXPECT_GT(sigma, 0.2 / std::sqrt(180) / 2);
  EXPECT_LT(sigma, 0.2 / std::sqrt(180) * 2.5);
  EXPECT_FALSE(FindCircle({{0, 0}, {1, 1}}, 1));
}

}  // namespace
}  // namespace ceilmap::calibration
