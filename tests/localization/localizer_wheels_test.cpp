#include <gtest/gtest.h>

#include <Eigen/LU>
#include <optional>
#include <random>

#include "calib/base/degrees.hpp"
#include "localization/localizer.hpp"
#include "tests/localization/visitor.hpp"

/// Robots with wheels: in the dark, where the wheels slip, and carried away.
namespace ceilmap::localization {
namespace {

using graph::TrackingStatus;
using synthetic::DistanceOf;
using synthetic::kStep;
using synthetic::TrueMap;
using synthetic::Visitor;

/// A visitor whose wheels have the errors that they state.
class WheeledVisitor : public Visitor {
 public:
  WheeledVisitor(const TrueMap& map, const Pose2& start, const LocalizerParams& params = {})
      : Visitor(map, synthetic::UpCamera(250, 0.5), params), truth_(start) {}

  double noise_per_sqrt_m = 0.01;  ///< of the travel

  const Pose2& Truth() const { return truth_; }

  /// @param slip_m  How much the wheels turn too far.
  Location Lit(const Pose2& step, double slip_m = 0) {
    truth_ = truth_ * step;
    const Location location = Locate(truth_, std::nullopt, Reported(step, slip_m));
    ExpectRight(location, truth_);
    return location;
  }
  /// Nothing but the noise of the sensor.
  Location Dark(const Pose2& step, bool reported = true, double repeated = 0) {
    truth_ = truth_ * step;
    cv::Mat noise(Uniform(0).size(), CV_32FC1);
    noise_.fill(noise, cv::RNG::NORMAL, 6, 1.5);
    cv::Mat image;
    noise.convertTo(image, CV_8U);
    const wheels::RelativeMotion wheels = Reported(step, 0);
    return Show(image, std::nullopt, reported ? std::optional(wheels) : std::nullopt, repeated);
  }
  /// Put down elsewhere; the wheels stand still.
  Location Carried(const Pose2& to) {
    IsCarriedAway();
    truth_ = to;
    return Locate(truth_, std::nullopt, wheels::RelativeMotion{});
  }

 private:
  wheels::RelativeMotion Reported(const Pose2& step, double slip_m) {
    const double length_m = step.Translation().norm();
    const double sigma_m = noise_per_sqrt_m * std::sqrt(length_m);
    const double sigma_rad = 2 * kRadPerDeg * std::sqrt(length_m);
    wheels::RelativeMotion motion;
    motion.T_before_now = step * Pose2{slip_m + sigma_m * normal_(random_), 0, 0} *
                          Pose2{0, 0, sigma_rad * normal_(random_)};
    motion.noise.diagonal() << sigma_m * sigma_m, sigma_m * sigma_m, sigma_rad * sigma_rad;
    motion.common.col(0) << 0.01 * step.x, 0.01 * step.y, 0;
    return motion;
  }

  Pose2 truth_;
  std::mt19937 random_{11};
  std::normal_distribution<double> normal_;
  cv::RNG noise_{5};
};

class LocalizerWheelsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap(); }
  static void TearDownTestSuite() { delete map_; }
  static TrueMap* map_;
};
TrueMap* LocalizerWheelsTest::map_ = nullptr;

/// Distance of a predicted pose from the truth, in standard deviations.
double Sigmas(const Location& location, const Pose2& truth) {
  const Pose2& T = location.pose.T_map_base;
  const Eigen::Vector3d error(T.x - truth.x, T.y - truth.y, WrapAngle(T.yaw - truth.yaw));
  return std::sqrt(error.dot(location.pose.covariance.inverse() * error));
}

TEST_F(LocalizerWheelsTest, LeadThroughTheDark) {
  WheeledVisitor visitor(*map_, {1.5, 1.2, 0});
  for (int i = 0; i < 8; ++i) (void)visitor.Lit(kStep);
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    double variance = 0;
    for (int i = 0; i < 15; ++i) {
      const Location location = visitor.Dark(kStep);
      ASSERT_EQ(location.pose.status, TrackingStatus::kPredicted) << i;
      EXPECT_FALSE(location.Placed());
      EXPECT_LT(Sigmas(location, visitor.Truth()), 4) << i;
      const double now = location.pose.covariance.topLeftCorner<2, 2>().trace();
      EXPECT_GT(now, variance) << i;
      variance = now;
    }
    EXPECT_LT(std::sqrt(variance), 0.1);
    for (int i = 0; i < 4; ++i) {
      const Location location = visitor.Lit(kStep);
      EXPECT_TRUE(location.Placed()) << i;
    }
  }
  EXPECT_EQ(visitor.Get().Report().predicted, 45);
  EXPECT_LE(visitor.Get().Report().lost, 1);
}

TEST_F(LocalizerWheelsTest, AnUnknownStepInTheDarkEndsThePrediction) {
  WheeledVisitor visitor(*map_, {1.5, 1.2, 0});
  for (int i = 0; i < 8; ++i) (void)visitor.Lit(kStep);
  EXPECT_EQ(visitor.Dark(kStep).pose.status, TrackingStatus::kPredicted);
  EXPECT_EQ(visitor.Dark(kStep, false).pose.status, TrackingStatus::kLost);
  EXPECT_EQ(visitor.Dark(kStep).pose.status, TrackingStatus::kLost);
  for (int i = 0; i < 6; ++i) (void)visitor.Lit(kStep);
  EXPECT_EQ(visitor.Dark(kStep).pose.status, TrackingStatus::kPredicted);
}

TEST_F(LocalizerWheelsTest, RepeatedImagesArePredicted) {
  WheeledVisitor visitor(*map_, {1.5, 1.2, 0});
  for (int i = 0; i < 8; ++i) (void)visitor.Lit(kStep);
  for (int i = 0; i < 5; ++i) {
    const Location location = visitor.Dark(kStep, true, 1);
    EXPECT_EQ(location.pose.status, TrackingStatus::kPredicted);
    EXPECT_LT(Sigmas(location, visitor.Truth()), 4) << i;
  }
  EXPECT_TRUE(visitor.Lit(kStep).Placed());
}

TEST_F(LocalizerWheelsTest, RepeatedImagesInTheDarkDoNotShortenTheWay) {
  WheeledVisitor visitor(*map_, {1.5, 1.2, 0});
  for (int i = 0; i < 8; ++i) (void)visitor.Lit(kStep);
  for (int i = 0; i < 2; ++i) (void)visitor.Dark(kStep);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(visitor.Dark(kStep, true, 1).pose.status, TrackingStatus::kPredicted);
  }
  EXPECT_TRUE(visitor.Lit(kStep).Placed());
}

TEST_F(LocalizerWheelsTest, ASlipLosesNoFrame) {
  WheeledVisitor visitor(*map_, {1.5, 1.2, 0});
  for (int i = 0; i < 8; ++i) (void)visitor.Lit(kStep);
  for (int i = 0; i < 40; ++i) {
    const Location location = visitor.Lit(kStep, i % 4 == 1 ? 0.5 : 0);
    EXPECT_EQ(location.pose.status, TrackingStatus::kTracking) << i;
  }
  EXPECT_GE(visitor.Get().Report().slips, 8);
}

TEST_F(LocalizerWheelsTest, ARobotThatWasCarriedAwayIsNoticed) {
  for (const Pose2& place : {Pose2{3.5, 3, 2}, Pose2{0.8, 3.1, -2}, Pose2{3.2, 1, 0.4}}) {
    SCOPED_TRACE(place.x);
    WheeledVisitor visitor(*map_, {1.2, 1.2, 0});
    for (int i = 0; i < 8; ++i) (void)visitor.Lit(kStep);
    Location location = visitor.Carried(place);
    Visitor::ExpectRight(location, place);
    int predicted = 0;
    for (; predicted < 25 && location.pose.status == TrackingStatus::kPredicted; ++predicted) {
      location = visitor.Lit({});
    }
    EXPECT_LT(predicted, 25);
    // It drives off, and is found.
    for (int i = 0; i < 12; ++i) location = visitor.Lit(kStep);
    EXPECT_EQ(location.pose.status, TrackingStatus::kTracking);
  }
}

TEST_F(LocalizerWheelsTest, ResetForgetsTheWheels) {
  WheeledVisitor visitor(*map_, {1.5, 1.2, 0});
  for (int i = 0; i < 8; ++i) (void)visitor.Lit(kStep);
  visitor.Get().Reset();
  EXPECT_EQ(visitor.Dark(kStep).pose.status, TrackingStatus::kLost);
}

/// Under tiles that are all the same, 0.6 m wide, started at a known pose.
class WheelsUnderTilesTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { map_ = new TrueMap(synthetic::Periodic()); }
  static void TearDownTestSuite() { delete map_; }
  static WheeledVisitor Started() {
    LocalizerParams params;
    PoseWithCovariance start{kStart};
    start.covariance.diagonal() << 1.6e-3, 1.6e-3, 4e-4;
    params.start = start;
    WheeledVisitor visitor(*map_, kStart, params);
    for (int i = 0; i < 8; ++i) EXPECT_TRUE(visitor.Lit(kAhead).Placed()) << i;
    return visitor;
  }

  static constexpr Pose2 kStart{1.2, 1.1, 0.2};
  static constexpr Pose2 kAhead{0.05, 0, 0};
  static TrueMap* map_;
};
TrueMap* WheelsUnderTilesTest::map_ = nullptr;

TEST_F(WheelsUnderTilesTest, GoodWheelsCountTheTilesInTheDark) {
  WheeledVisitor visitor = Started();
  for (int i = 0; i < 20; ++i) (void)visitor.Dark(kAhead);
  for (int i = 0; i < 6; ++i) EXPECT_TRUE(visitor.Lit(kAhead).Placed()) << i;
}

TEST_F(WheelsUnderTilesTest, PoorWheelsLeaveTheTileOpen) {
  WheeledVisitor visitor = Started();
  visitor.noise_per_sqrt_m = 0.25;
  for (int i = 0; i < 20; ++i) (void)visitor.Dark(kAhead);
  for (int i = 0; i < 6; ++i) EXPECT_FALSE(visitor.Lit(kAhead).Placed()) << i;
}

TEST_F(WheelsUnderTilesTest, ACarriedRobotIsNotPlacedAtItsOldPose) {
  for (const double off : {-0.25, -0.1, 0.13, 0.28}) {
    WheeledVisitor visitor = Started();
    Pose2 T = visitor.Truth();
    T = {T.x + 0.6 + off, T.y + 0.6 - 0.5 * off, T.yaw + 0.1};
    EXPECT_FALSE(visitor.Carried(T).Placed()) << off;
    for (int i = 0; i < 12; ++i) EXPECT_FALSE(visitor.Lit(kAhead).Placed()) << off << " " << i;
  }
}

}  // namespace
}  // namespace ceilmap::localization
