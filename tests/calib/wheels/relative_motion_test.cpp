#include "calib/wheels/relative_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ceilmap::wheels {
namespace {

TEST(RelativeMotion, CommonErrorsAddUpAsLengths) {
  RelativeMotion step;
  step.T_before_now = {1, 0, 0};
  step.noise.diagonal() << 0.01, 0.01, 0;
  step.common.col(0) << 0.1, 0, 0;
  const RelativeMotion both = step * step;
  EXPECT_NEAR(both.T_before_now.x, 2, 1e-12);
  // Noise as variances, 0.02; the common error as a length, 0.2 squared.
  EXPECT_NEAR(both.Covariance()(0, 0), 0.02 + 0.04, 1e-12);
  EXPECT_NEAR(both.Covariance()(1, 1), 0.02, 1e-12);
}

TEST(RelativeMotion, ATurnThatIsWrongDisplacesLaterSteps) {
  RelativeMotion turn;
  turn.T_before_now = {0, 0, std::numbers::pi / 2};
  turn.common.col(1) << 0, 0, 0.1;
  RelativeMotion step;
  step.T_before_now = {2, 0, 0};
  const RelativeMotion both = turn * step;
  // The step leads along y; turned further by 0.1 it leads 0.2 towards -x.
  EXPECT_NEAR(both.T_before_now.y, 2, 1e-12);
  EXPECT_NEAR(both.common(0, 1), -0.2, 1e-12);
  EXPECT_NEAR(both.common(1, 1), 0, 1e-12);
  EXPECT_NEAR(both.common(2, 1), 0.1, 1e-12);
}

TEST(RelativeMotion, IsAssociative) {
  RelativeMotion a;
  a.T_before_now = {0.3, -0.1, 0.4};
  a.noise << 2, 0.1, 0.2, 0.1, 1, 0.3, 0.2, 0.3, 3;
  a.common << 0.3, 0.1, 0, 0.2, 0.1, 0.4;
  RelativeMotion b = a;
  b.T_before_now = {-0.5, 0.7, 1.1};
  RelativeMotion c = a;
  c.T_before_now = {0.9, 0.2, -2.3};
  const RelativeMotion left = (a * b) * c;
  const RelativeMotion right = a * (b * c);
  EXPECT_NEAR((left.noise - right.noise).norm(), 0, 1e-12);
  EXPECT_NEAR((left.common - right.common).norm(), 0, 1e-12);
}

RelativeMotion WithErrors(const Pose2& T_before_now) {
  RelativeMotion motion;
  motion.T_before_now = T_before_now;
  motion.noise << 4e-4, 1e-4, 2e-4, 1e-4, 3e-4, -1e-4, 2e-4, -1e-4, 5e-4;
  motion.common << 0.03, -0.01, 0.005, 0.02, 0, 0.04;
  return motion;
}

TEST(RelativeMotion, BackIsTheInverseOfFrom) {
  const RelativeMotion motion = WithErrors({0.7, -0.4, 1.3});
  const PoseWithCovariance before{{-1.2, 2.5, 2.8}};
  const PoseWithCovariance back = motion.Back({motion.From(before).pose});
  EXPECT_NEAR(back.pose.x, before.pose.x, 1e-12);
  EXPECT_NEAR(back.pose.y, before.pose.y, 1e-12);
  EXPECT_NEAR(WrapAngle(back.pose.yaw - before.pose.yaw), 0, 1e-12);
}

Eigen::Vector3d AsVector(const Pose2& T) {
  return {T.x, T.y, T.yaw};
}
Pose2 AsPose(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

/// Covariance of a pose to first order, by the numeric derivatives of `pose_of` with respect to an
/// end and a motion.
template <typename PoseOf>
Eigen::Matrix3d ByDifferences(const PoseWithCovariance& end,
                              const RelativeMotion& motion,
                              const PoseOf& pose_of) {
  constexpr double kStep = 1e-6;
  const auto derivative = [&](const auto& of) {
    Eigen::Matrix3d J;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
      J.col(i) = (AsVector(of(d)) - AsVector(of(-d))) / (2 * kStep);
    }
    return J;
  };
  const Eigen::Matrix3d by_end = derivative([&](const Eigen::Vector3d& d) {
    return pose_of(AsPose(AsVector(end.pose) + d), motion.T_before_now);
  });
  const Eigen::Matrix3d by_motion = derivative([&](const Eigen::Vector3d& d) {
    return pose_of(end.pose, AsPose(AsVector(motion.T_before_now) + d));
  });
  return by_end * end.covariance * by_end.transpose() +
         by_motion * motion.Covariance() * by_motion.transpose();
}

TEST(RelativeMotion, StatesTheErrorsOfBothDirections) {
  const RelativeMotion motion = WithErrors({0.7, -0.4, 1.3});
  PoseWithCovariance end{{-1.2, 2.5, 0.6}};
  end.covariance << 2e-4, 0.5e-4, 1e-4, 0.5e-4, 3e-4, 0, 1e-4, 0, 4e-4;
  const Eigen::Matrix3d forwards =
      ByDifferences(end, motion, [](const Pose2& before, const Pose2& T) { return before * T; });
  EXPECT_NEAR((motion.From(end).covariance - forwards).norm(), 0, 1e-9);
  const Eigen::Matrix3d backwards = ByDifferences(
      end, motion, [](const Pose2& now, const Pose2& T) { return now * T.Inverse(); });
  EXPECT_NEAR((motion.Back(end).covariance - backwards).norm(), 0, 1e-9);
}

TEST(RelativeMotion, JoinedIsUnknownWhereAPartIs) {
  const RelativeMotion a = WithErrors({0.7, -0.4, 1.3});
  const RelativeMotion b = WithErrors({0.1, 0.2, -0.5});
  ASSERT_TRUE(Joined(a, b));
  EXPECT_NEAR(Joined(a, b)->T_before_now.x, (a * b).T_before_now.x, 1e-15);
  EXPECT_FALSE(Joined(a, std::nullopt));
  EXPECT_FALSE(Joined(std::nullopt, b));
}

}  // namespace
}  // namespace ceilmap::wheels
