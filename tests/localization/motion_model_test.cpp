#include "localization/motion_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "calib/base/error.hpp"

namespace ceilmap::localization {
namespace {

PoseWithCovariance Known(const Pose2& T, double sigma = 1e-3, double sigma_rad = 1e-3) {
  PoseWithCovariance pose{T};
  pose.covariance.diagonal() << sigma * sigma, sigma * sigma, sigma_rad * sigma_rad;
  return pose;
}

TEST(MotionModel, LearnsAnEvenSpeedAndKeepsIt) {
  MotionModel model;
  EXPECT_FALSE(model.Started());
  const Pose2 step{0.05, 0.01, 0.03};  // along an arc, 0.1 s each
  Pose2 T{1, 2, 3.1};
  model.Start(Known(T), 0);
  for (int i = 1; i <= 30; ++i) {
    T = T * step;
    model.Predict(0.1 * i);
    model.Update(Known(T));
  }
  EXPECT_NEAR(model.Velocity().x(), 0.5, 0.03);
  EXPECT_NEAR(model.Velocity().y(), 0.1, 0.03);
  EXPECT_NEAR(model.Velocity().z(), 0.3, 0.02);
  const PoseWithCovariance later = model.PredictedAt(3.3);
  const Pose2 expected = T * step * step * step;
  EXPECT_NEAR(later.pose.x, expected.x, 5e-3);
  EXPECT_NEAR(later.pose.y, expected.y, 5e-3);
  EXPECT_NEAR(WrapAngle(later.pose.yaw - expected.yaw), 0, 5e-3);
  EXPECT_EQ(model.Stamp(), 3.0);  // PredictedAt changes nothing
}

TEST(MotionModel, StartsWithAVelocityThatWasMeasuredBefore) {
  const Pose2 T{1, 2, 1.5};
  const Twist2 velocity{{0.6, -0.1}, 0.4};
  MotionModel model;
  EXPECT_FALSE(model.KnowsVelocity());
  model.Start(Known(T), 5, velocity);
  EXPECT_TRUE(model.KnowsVelocity());
  EXPECT_EQ(model.Velocity(), Eigen::Vector3d(0.6, -0.1, 0.4));
  const PoseWithCovariance later = model.PredictedAt(5.5);
  const Pose2 expected = T * Pose2{0, 0, 0.1} * Pose2{0.3, -0.05, 0.1};  // along the chord
  EXPECT_NEAR(later.pose.x, expected.x, 1e-3);
  EXPECT_NEAR(later.pose.y, expected.y, 1e-3);
  EXPECT_NEAR(later.pose.yaw, expected.yaw, 1e-9);
  // It is not exact: the robot may have braked since.
  EXPECT_GT(std::sqrt(later.covariance(0, 0)), 0.5 * MotionModel::kStartSpeedSigma);
  MotionModel unknown;
  unknown.Start(Known(T), 5);
  EXPECT_EQ(unknown.PredictedAt(5.5).pose.x, T.x);
  EXPECT_LT(later.covariance(0, 0), unknown.PredictedAt(5.5).covariance(0, 0));
}

TEST(MotionModel, KnowsAVelocityOnlyOnceItWasMeasured) {
  MotionModel model;
  model.Start(Known({}), 0);
  EXPECT_FALSE(model.KnowsVelocity());
  for (int i = 1; i <= 5; ++i) {
    model.Predict(0.1 * i);
    model.Update(Known({0.05 * i, 0, 0}));
  }
  EXPECT_TRUE(model.KnowsVelocity());
  model.Predict(3);  // for so long it may have changed at any rate
  EXPECT_FALSE(model.KnowsVelocity());
  model.Start(Known({}), 3, Twist2{{0.5, 0}, 0});
  EXPECT_TRUE(model.KnowsVelocity());
  model.Start(Known({}), 4);
  EXPECT_FALSE(model.KnowsVelocity());
  EXPECT_EQ(model.Velocity(), Eigen::Vector3d::Zero());
  model.Start(Known({}), 4, Twist2{});
  model.Stop();
  EXPECT_FALSE(model.KnowsVelocity());
}

TEST(MotionModel, KnowsTheVelocityAtThreeFramesASecond) {
  MotionModel model;
  model.Start(Known({}), 0);
  for (int i = 1; i <= 6; ++i) {
    model.Predict(i / 3.0);
    model.Update(Known({0.8 * i, 0, 0}));
  }
  EXPECT_TRUE(model.KnowsVelocity());
}

TEST(MotionModel, UncertaintyGrowsWithoutMeasurements) {
  MotionModel model;
  model.Start(Known({}), 10);
  double before = 0;
  for (const double ahead : {0.0, 0.05, 0.1, 0.5, 2.0}) {
    const double variance = model.PredictedAt(10 + ahead).covariance(0, 0);
    EXPECT_GT(variance, before);
    before = variance;
  }
  EXPECT_GT(before, 1);  // after two seconds it may be anywhere near
  EXPECT_EQ(model.PredictedAt(9).covariance(0, 0), model.Pose().covariance(0, 0));
}

TEST(MotionModel, ErrorsAreAsLargeAsItSays) {
  // Robots that move by the model: its normalised squared error must average 3.
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  const MotionModelParams params;
  constexpr double kDt = 0.1;
  double sum = 0;
  int count = 0;
  for (int robot = 0; robot < 300; ++robot) {
    Pose2 T;
    Eigen::Vector3d v(MotionModel::kFirstSpeedSigma * normal(random),
                      MotionModel::kFirstSpeedSigma * normal(random),
                      MotionModel::kFirstTurnSigma * normal(random));
    MotionModel model;
    const auto measure = [&] {
      constexpr double kSigma = 0.01;
      return Known({T.x + kSigma * normal(random),
                    T.y + kSigma * normal(random),
                    T.yaw + kSigma * normal(random)},
                   kSigma,
                   kSigma);
    };
    model.Start(measure(), 0);
    for (int i = 1; i <= 15; ++i) {
      constexpr int kSteps = 20;
      for (int k = 0; k < kSteps; ++k) {
        const double dt = kDt / kSteps;
        T = T * Pose2{v.x() * dt, v.y() * dt, v.z() * dt};
        v.x() += std::sqrt(params.speed_noise * dt) * normal(random);
        v.y() += std::sqrt(params.speed_noise * dt) * normal(random);
        v.z() += std::sqrt(params.turn_noise * dt) * normal(random);
      }
      model.Predict(kDt * i);
      sum += SquaredDistance(model.Pose(), {T});
      ++count;
      model.Update(measure());
    }
  }
  EXPECT_NEAR(sum / count, 3, 0.45);
}

TEST(MotionModel, TakesAHeadingAlone) {
  MotionModel model;
  model.Start(Known({0, 0, 3.1}, 0.01, 0.2), 0);
  model.UpdateYaw(-3.1, 1e-6);  // across the turn
  EXPECT_NEAR(model.Pose().pose.yaw, -3.1, 1e-4);
  EXPECT_NEAR(model.Pose().covariance(2, 2), 1e-6, 1e-8);
  EXPECT_EQ(model.Pose().pose.x, 0);
}

TEST(PoseEstimates, DistanceAndMotion) {
  const PoseWithCovariance a = Known({0, 0, 3.1}, 0.1, 0.1);
  const PoseWithCovariance b = Known({0.3, 0, -3.1}, 0.1, 0.1);
  const double turn = 2 * (std::acos(-1.0) - 3.1);
  EXPECT_NEAR(SquaredDistance(a, b), (0.09 + turn * turn) / 0.02, 1e-9);
  const PoseWithCovariance moved =
      Moved(Known({1, 1, 0}, 0.1, 0.01), {2, 0, 1}, Eigen::Matrix3d::Zero());
  EXPECT_NEAR(moved.pose.x, 3, 1e-12);
  // The heading's error swings the robot sideways.
  EXPECT_NEAR(moved.covariance(1, 1), 0.01 + 4 * 1e-4, 1e-9);
}

TEST(MotionModel, RefusesImpossibleParameters) {
  MotionModelParams params;
  params.turn_noise = 0;
  EXPECT_THROW(MotionModel{params}, InputError);
}

}  // namespace
}  // namespace ceilmap::localization
