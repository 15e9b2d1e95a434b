#include "localization/compass/colour/yaw_belief.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::colour {
namespace {

using std::numbers::pi;

/// A row of places along x, with a step between them.
std::vector<Place> Row(int count) {
  std::vector<Place> places;
  for (int i = 0; i < count; ++i) {
    places.push_back({Eigen::Vector2d(i, 0), 0, DirectionTable({0, 0}, 180), {}});
    places.back().neighbours = {i - 1, i + 1 < count ? i + 1 : -1, -1, -1};
  }
  return places;
}

/// Log-likelihood of a peak at a place and a yaw.
YawBelief::Histogram Peak(
    const YawBelief& belief, int places, int place, double yaw, double sigma) {
  YawBelief::Histogram log(places, YawBelief::kYaws);
  for (int i = 0; i < places; ++i) {
    for (int column = 0; column < YawBelief::kYaws; ++column) {
      const double off = std::remainder(belief.YawOf(column) - yaw, 2 * pi) / sigma;
      log(i, column) = static_cast<float>(-0.5 * off * off - (i == place ? 0 : 20));
    }
  }
  return log;
}

TEST(YawBelief, IsUniformAtTheStart) {
  const YawBelief belief(3);
  const YawBelief::Estimate yaw = belief.Yaw();
  EXPECT_NEAR(yaw.variance_rad2, pi * pi / 3, 0.05);
  EXPECT_LT(yaw.confidence, 0.2);
  EXPECT_NEAR(belief.Places()(1), 1 / 3.0, 1e-5);
}

TEST(YawBelief, TurnsAreExactAndAddTheirVariance) {
  YawBelief belief(1);
  belief.Weigh(Peak(belief, 1, 0, 1.0, 0.1));
  EXPECT_NEAR(belief.Yaw().yaw_rad, 1, 1e-3);
  const double before = belief.Yaw().variance_rad2;
  EXPECT_NEAR(before, 0.01, 3e-4);
  for (int i = 0; i < 50; ++i) belief.Turn(0.0123, 0.01);
  EXPECT_NEAR(belief.Yaw().yaw_rad, 1 + 50 * 0.0123, 2e-3);
  EXPECT_NEAR(belief.Yaw().variance_rad2, before + 50 * 1e-4, 3e-4);
  belief.Turn(0, 100);
  EXPECT_GT(belief.Yaw().variance_rad2, 1) << "nothing is known any more";
}

TEST(YawBelief, TwoPeaksAreNoConfidence) {
  YawBelief belief(1);
  YawBelief::Histogram log = Peak(belief, 1, 0, 0.5, 0.05);
  const YawBelief::Histogram other = Peak(belief, 1, 0, 0.5 + pi, 0.05);
  log = log.cwiseMax((other.array() - 0.2F).matrix());
  belief.Weigh(log);
  EXPECT_NEAR(belief.Yaw().yaw_rad, 0.5, 0.2 + pi * 0.6);
  EXPECT_LT(belief.Yaw().confidence, 0.65);
  EXPECT_GT(belief.Yaw().variance_rad2, 1);
}

TEST(YawBelief, DrivesInTheDirectionOfTheYaw) {
  const std::vector<Place> places = Row(9);
  for (const double yaw : {0.0, pi}) {
    YawBelief belief(9);
    belief.Weigh(Peak(belief, 9, 4, yaw, 0.1));
    for (int i = 0; i < 10; ++i) belief.Drive(0.2, places);  // two steps
    const Eigen::VectorXf of_places = belief.Places();
    EXPECT_GT(of_places(yaw == 0 ? 6 : 2), 0.9F);
    for (int i = 0; i < 100; ++i) belief.Drive(0.2, places);
    EXPECT_GT(belief.Places()(yaw == 0 ? 8 : 0), 0.9F) << "stays at the edge";
    EXPECT_NEAR(belief.Places().sum(), 1, 1e-4);
  }
}

TEST(YawBelief, AKnownPlaceKeepsTheYaw) {
  YawBelief belief(9);
  belief.Weigh(Peak(belief, 9, 4, 1, 0.1));
  Eigen::VectorXf weights = Eigen::VectorXf::Zero(9);
  weights(7) = 1;
  belief.WeighYaws(Eigen::RowVectorXf::Ones(YawBelief::kYaws), weights);
  EXPECT_GT(belief.Places()(7), 0.99F);
  EXPECT_NEAR(belief.Yaw().yaw_rad, 1, 1e-3);
}

TEST(YawBelief, FindsARobotThatWasCarriedAway) {
  YawBelief belief(1);
  for (int i = 0; i < 20; ++i) belief.Weigh(Peak(belief, 1, 0, 1, 0.1));
  for (int i = 0; i < 20; ++i) belief.Weigh(Peak(belief, 1, 0, -2, 0.1).cwiseMax(-8));
  EXPECT_NEAR(belief.Yaw().yaw_rad, -2, 0.02);
}

}  // namespace
}  // namespace ceilmap::colour
