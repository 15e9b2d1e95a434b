// A localizer under a ceiling whose tiles are all the same.

#include <gtest/gtest.h>

#include <random>

#include "localization/localizer.hpp"
#include "tests/localization/visitor.hpp"

namespace ceilmap::localization {
namespace {

using graph::TrackingStatus;
using synthetic::Periodic;
using synthetic::TrueMap;
using synthetic::UpCamera;
using synthetic::Visitor;

const Pose2 kFirst{1.2, 1.1, 0.2};

class PeriodicMap : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap(Periodic()); }
  static void TearDownTestSuite() { delete map_; }
  /// Started at a pose that is known with this standard deviation in metres, and 1.1 degrees.
  static LocalizerParams StartingAt(const Pose2& T_map_base, double sigma) {
    LocalizerParams params;
    PoseWithCovariance start{T_map_base};
    start.covariance.diagonal() << sigma * sigma, sigma * sigma, 4e-4;
    params.start = start;
    return params;
  }
  /// Straight ahead, for this number of frames, which must all be placed.
  static void DriveOn(Visitor& visitor, Pose2& T, int frames) {
    for (int i = 0; i < frames; ++i) {
      const Location location = visitor.Locate(T);
      EXPECT_TRUE(location.Placed()) << i;
      Visitor::ExpectRight(location, T);
      T = T * Pose2{0.05, 0, 0};
    }
  }

  static TrueMap* map_;
};
TrueMap* PeriodicMap::map_ = nullptr;

TEST_F(PeriodicMap, NoPlaceIsAccepted) {
  Visitor visitor(*map_);
  Pose2 T{1, 1, 0};
  bool ambiguous = false;
  for (int i = 0; i < 40; ++i) {
    T = T * Pose2{0.05, 0, 0.01};
    const Location location = visitor.Locate(T);
    EXPECT_FALSE(location.Placed());
    ambiguous = ambiguous || location.pose.status == TrackingStatus::kAmbiguous;
  }
  EXPECT_TRUE(ambiguous);
}

TEST_F(PeriodicMap, AStartKnownWellIsFollowed) {
  Visitor visitor(*map_, UpCamera(250, 0.5), StartingAt(kFirst, 0.04));
  Pose2 T = kFirst;
  DriveOn(visitor, T, 30);
}

TEST_F(PeriodicMap, AStartKnownBadlyIsNot) {
  Visitor visitor(*map_, UpCamera(250, 0.5), StartingAt({1.5, 1.1, 0.2}, 0.3));
  Pose2 T = kFirst;
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(visitor.Locate(T).Placed());
    T = T * Pose2{0.05, 0, 0.01};
  }
}

TEST_F(PeriodicMap, ACarriedRobotIsNotPlacedAtItsOldPose) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> off(-0.29, 0.29);  // within a tile of 0.6 m
  for (int trial = 0; trial < 8; ++trial) {
    Visitor visitor(*map_, UpCamera(250, 0.5), StartingAt(kFirst, 0.04));
    Pose2 T = kFirst;
    DriveOn(visitor, T, 8);
    T = Pose2{T.x + 1.2 + off(random), T.y + 0.6 + off(random), T.yaw + 0.1};
    for (int i = 0; i < 10; ++i) {
      EXPECT_FALSE(visitor.Locate(T).Placed()) << trial << " " << i;
      T = T * Pose2{0.05, 0, 0};
    }
  }
}

TEST_F(PeriodicMap, ABlinkDoesNotEndIt) {
  Visitor visitor(*map_, UpCamera(250, 0.5), StartingAt(kFirst, 0.04));
  Pose2 T = kFirst;
  DriveOn(visitor, T, 12);
  EXPECT_EQ(visitor.Show(visitor.Uniform(20)).pose.status, TrackingStatus::kLost);
  T = T * Pose2{0.05, 0, 0};
  const Location after = visitor.Locate(T);
  EXPECT_EQ(after.pose.status, TrackingStatus::kRelocalized);
  Visitor::ExpectRight(after, T);
}

TEST_F(PeriodicMap, DarknessInWhichTheRobotDroveLeavesItOpen) {
  for (const bool dark_at_once : {true, false}) {
    Visitor visitor(*map_, UpCamera(250, 0.5), StartingAt(kFirst, 0.04));
    Pose2 T = kFirst;
    if (!dark_at_once) DriveOn(visitor, T, 8);
    for (int i = 0; i < 30; ++i) visitor.Show(visitor.Uniform(20));
    T = T * Pose2{0.9, 0.3, 0};
    for (int i = 0; i < 6; ++i) {
      EXPECT_FALSE(visitor.Locate(T).Placed()) << dark_at_once;
      T = T * Pose2{0.05, 0, 0};
    }
  }
}

/// Under one marked tile, which determines the position but not the quarter turn of the robot.
const Pose2 kMark{1.8, 1.8, 0.2};

TEST(MarkedTile, ACompassResolvesTheQuarterTurnInTheDark) {
  synthetic::CeilingParams ceiling = Periodic();
  ceiling.own_marks = {kMark.Translation() / synthetic::kUnit_m};
  const TrueMap map(ceiling);
  for (const bool compass : {true, false}) {
    LocalizerParams params;
    params.start = PoseWithCovariance{kMark, Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal()};
    Visitor visitor(map, UpCamera(250, 0.5), params);
    Pose2 T = kMark;
    double variance = 1e-9;
    const auto heading = [&] {
      variance += 1e-6;
      return compass ? std::optional(HeadingPrior{WrapAngle(T.yaw + 2.2), variance}) : std::nullopt;
    };
    for (int i = 0; i < 6; ++i) EXPECT_TRUE(visitor.Locate(T, heading()).Placed()) << i;
    variance += 0.05;  // it has drifted for long
    EXPECT_TRUE(visitor.Locate(T, heading()).Placed());
    for (int i = 0; i < 8; ++i) {
      T.yaw += 0.2;
      (void)visitor.Show(visitor.Uniform(20), heading());
    }
    int placed = 0;
    for (int i = 0; i < 14; ++i) {
      T = T * Pose2{0.04, 0, 0};
      const Location location = visitor.Locate(T, heading());
      placed += location.Placed() ? 1 : 0;
      if (compass) Visitor::ExpectRight(location, T);
    }
    if (compass) {
      EXPECT_GE(placed, 6);
    } else {
      EXPECT_EQ(placed, 0);
    }
  }
}

}  // namespace
}  // namespace ceilmap::localization
