#include "app/page/plan_picture.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/imgcodecs.hpp>

namespace ceilmap::page {
namespace {

using Eigen::Vector2d;

constexpr double kEast = 691'000.125;  // needs more digits than a float has
constexpr double kNorth = 5'335'000.25;

std::size_t PointsOf(const PagePlan& plan) {
  std::size_t points = 0;
  for (const auto& line : plan.lines) points += line.size();
  return points;
}

TEST(PlanPicture, LinesKeepTheirPlaces) {
  store::SitePlan plan;
  plan.lines = {{{kEast, kNorth}, {kEast + 10, kNorth}, {kEast + 10, kNorth + 5}}};
  const PagePlan made = MakePlan(plan);
  EXPECT_TRUE(made.bytes.empty());
  ASSERT_EQ(made.lines.size(), 1U);
  ASSERT_EQ(made.lines[0].size(), 3U);
  EXPECT_EQ(made.lines[0][0][0], kEast);
  EXPECT_EQ(made.lines[0][2][0], kEast + 10);
  EXPECT_EQ(made.lines[0][2][1], kNorth + 5);
}

TEST(PlanPicture, RingsStayClosed) {
  store::SitePlan plan;
  plan.lines = {{{0, 0}, {4, 0}, {4, 3}, {0, 3}, {0, 0}}};
  const PagePlan made = MakePlan(plan);
  ASSERT_EQ(made.lines.size(), 1U);
  EXPECT_EQ(made.lines[0].size(), 5U);
  EXPECT_EQ(made.lines[0].front(), made.lines[0].back());
}

TEST(PlanPicture, PointsThatDrawNothingAreLeftOut) {
  store::SitePlan plan;
  plan.lines.emplace_back();
  for (int i = 0; i <= 1000; ++i) plan.lines[0].emplace_back(0.01 * i, i % 2 == 0 ? 0 : 5e-4);
  plan.lines.push_back({{3, 3}, {3.0005, 3}});  // shorter than a millimetre
  plan.lines.push_back({{4, 4}});
  plan.lines.push_back({{5, 5}, {std::numeric_limits<double>::quiet_NaN(), 5}});
  const PagePlan made = MakePlan(plan);
  ASSERT_EQ(made.lines.size(), 1U);
  EXPECT_EQ(made.lines[0].size(), 2U);
}

TEST(PlanPicture, OfTooManyPointsTheFinestAreLeftOut) {
  store::SitePlan plan;
  for (int k = 0; k < 20; ++k) {
    plan.lines.emplace_back();
    for (int i = 0; i < 500; ++i) {
      const double angle = 2 * M_PI * i / 500;
      plan.lines.back().emplace_back(kEast + k + 5 * std::cos(angle), kNorth + 5 * std::sin(angle));
    }
  }
  const std::size_t all = PointsOf(MakePlan(plan));
  const PagePlan few = MakePlan(plan, kMaxPictureBytes, 400);
  EXPECT_GT(all, 400U);
  EXPECT_LE(PointsOf(few), 400U);
  EXPECT_EQ(few.lines.size(), 20U);
  for (const auto& [x, y] : few.lines[0]) {
    EXPECT_NEAR(std::hypot(x - kEast, y - kNorth), 5, 1e-3);
  }
}

TEST(PlanPicture, AnImageKeepsPixelsAndCorners) {
  store::SitePlan plan;
  plan.image = cv::Mat(30, 40, CV_8UC3, cv::Scalar(255, 255, 255));
  plan.image.at<cv::Vec3b>(2, 3) = {10, 20, 200};
  plan.transform = {100, 0, 0.5, 200, 0.5, 0};  // columns go up, rows to the right
  const PagePlan made = MakePlan(plan);
  EXPECT_TRUE(made.lines.empty());
  EXPECT_EQ(made.corners[0], (std::array<double, 2>{100, 200}));
  EXPECT_EQ(made.corners[1], (std::array<double, 2>{100, 220}));
  EXPECT_EQ(made.corners[2], (std::array<double, 2>{115, 200}));
  const cv::Mat decoded = cv::imdecode(made.bytes, cv::IMREAD_COLOR);
  ASSERT_EQ(decoded.size(), plan.image.size());
  EXPECT_EQ(cv::norm(decoded, plan.image, cv::NORM_INF), 0);
}

TEST(PlanPicture, ALargeImageBecomesSmallerInItsPlace) {
  store::SitePlan plan;
  plan.image = cv::Mat(300, 400, CV_8UC3);
  cv::RNG(1).fill(plan.image, cv::RNG::UNIFORM, 0, 255);
  plan.transform = {100, 0.1, 0, 200, 0, -0.1};
  const PagePlan made = MakePlan(plan, 20'000);
  EXPECT_LE(made.bytes.size(), 20'000U);
  EXPECT_EQ(made.corners, MakePlan(plan).corners);
  EXPECT_LT(cv::imdecode(made.bytes, cv::IMREAD_COLOR).cols, 400);
}

}  // namespace
}  // namespace ceilmap::page
