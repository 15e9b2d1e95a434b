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

}  // namespace
}  // namespace ceilmap::wheels
