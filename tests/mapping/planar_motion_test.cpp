#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "calib/base/pose_with_covariance.hpp"
#include "calib/level_view.hpp"
#include "mapping/planar_motion.hpp"

namespace ceilmap::mapping {
namespace {

using calib::CeilingView;
using registration::ImageMotion;

constexpr double kPi = std::numbers::pi;

/// Camera 0.2 m ahead of base, 0.1 m to its right, turned by 0.3 rad; 5 mm per pixel.
CeilingView OffsetView() {
  calib::MountedCamera up;
  up.camera = {640, 480, 440, 440, 319.5, 239.5, {}};
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(kPi / 2 + 0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0.2, -0.1, 0.4);
  return {up, 2.6};
}

void ExpectPose(const Pose2& pose, double x, double y, double yaw, double tolerance = 1e-12) {
  EXPECT_NEAR(pose.x, x, tolerance);
  EXPECT_NEAR(pose.y, y, tolerance);
  EXPECT_NEAR(WrapAngle(pose.yaw - yaw), 0, tolerance);
}

Pose2 RandomPose(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {unit(random), unit(random), 3 * unit(random)};
}

TEST(BaseMotion, SignsByHand) {
  const CeilingView view = CeilingView::InPixels({640, 480});
  // Forward is up in the image: the ceiling runs down the screen.
  ExpectPose(BaseMotion(view, {0, 10, 0, 1}), 10, 0, 0);
  // The robot's left is the image's right: when it moves left, the ceiling runs to the left.
  ExpectPose(BaseMotion(view, {-10, 0, 0, 1}), 0, 10, 0);
  // A left turn turns the content counter-clockwise on the screen.
  ExpectPose(BaseMotion(view, {0, 0, -0.1, 1}), 0, 0, 0.1);
  ExpectPose(BaseMotion(view, {}), 0, 0, 0);
}

TEST(OverlapOf, ByHand) {
  const CeilingView view = OffsetView();  // 3.2 m x 2.4 m of ceiling
  EXPECT_NEAR(SpanOf(view), 3.2, 1e-12);
  EXPECT_EQ(OverlapOf(view, {}), 1);
  // The image's x axis lies 0.3 rad to the left of the robot's right.
  const double c = std::cos(0.3);
  const double s = std::sin(0.3);
  EXPECT_NEAR(OverlapOf(view, {0.8 * s, -0.8 * c, 0}), 0.75, 0.01);
  EXPECT_NEAR(OverlapOf(view, {1.2 * c, 1.2 * s, 0}), 0.5, 0.01);
  EXPECT_EQ(OverlapOf(view, {4, 0, 0}), 0);
}

TEST(BaseMotion, InMetresByHand) {
  calib::MountedCamera up;
  up.camera = {640, 480, 440, 440, 319.5, 239.5, {}};
  up.T_base_cam.linear() = Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0.2, 0, 0.4);
  const CeilingView view(up, 2.6);
  ExpectPose(BaseMotion(view, {0, 20, 0, 1}), 0.1, 0, 0);
  // A camera 0.2 m ahead of the axis moves by 0.2 m to the left in a quarter turn to the left, and
  // ends 0.2 m less far ahead. Its image's centre c is then seen at R (0) + t.
  const Pose2 T_ref_cur = {0, 0, kPi / 2};
  const ImageMotion motion = ImageMotionOf(view, T_ref_cur);
  EXPECT_NEAR(motion.theta_rad, -kPi / 2, 1e-12);
  // What was over the camera (0.2 m ahead) is now 0.2 m to the robot's right of its axis, that is
  // 40 px left of the axis in the image, and the axis is 40 px below the centre.
  EXPECT_NEAR(motion.tx_px, -40, 1e-9);
  EXPECT_NEAR(motion.ty_px, 40, 1e-9);
}

TEST(BaseMotion, RoundTrip) {
  std::mt19937 random(1);
  for (const CeilingView& view : {CeilingView::InPixels({640, 480}), OffsetView()}) {
    for (int i = 0; i < 50; ++i) {
      const Pose2 T = RandomPose(random);
      const ImageMotion motion = ImageMotionOf(view, T);
      EXPECT_EQ(motion.scale, 1);
      ExpectPose(BaseMotion(view, motion), T.x, T.y, T.yaw, 1e-9);
    }
  }
}

TEST(BaseMotion, ComposesLikeTheImageMotions) {
  std::mt19937 random(2);
  const CeilingView view = OffsetView();
  for (int i = 0; i < 50; ++i) {
    const Pose2 T_a_b = RandomPose(random);
    const Pose2 T_b_c = RandomPose(random);
    const ImageMotion a_to_c = Compose(ImageMotionOf(view, T_b_c), ImageMotionOf(view, T_a_b));
    const Pose2 T_a_c = T_a_b * T_b_c;
    ExpectPose(BaseMotion(view, a_to_c), T_a_c.x, T_a_c.y, T_a_c.yaw, 1e-9);
  }
}

TEST(BaseMotion, FollowsAPointOfTheCeiling) {
  // p_ref = T_ref_cur p_cur for a point seen in both images.
  std::mt19937 random(3);
  const CeilingView view = OffsetView();
  const double m = view.MetresPerPixel();
  for (int i = 0; i < 20; ++i) {
    const Pose2 T_ref_cur = RandomPose(random);
    const Eigen::Vector2d x(11.0 * i - 90, 70 - 5.0 * i);
    const Eigen::Vector2d seen = ImageMotionOf(view, T_ref_cur).Apply(x);
    const Eigen::Vector2d p_ref = view.T_base_view() * Eigen::Vector2d(m * x);
    const Eigen::Vector2d p_cur = view.T_base_view() * Eigen::Vector2d(m * seen);
    EXPECT_LT((T_ref_cur * p_cur - p_ref).norm(), 1e-9);
  }
}

Eigen::Matrix3d SomeCovariance(double sigma_x, double sigma_y, double sigma_yaw) {
  Eigen::Matrix3d correlation;
  correlation << 1, 0.3, -0.2, 0.3, 1, 0.4, -0.2, 0.4, 1;
  const Eigen::Vector3d s(sigma_x, sigma_y, sigma_yaw);
  return s.asDiagonal() * correlation * s.asDiagonal();
}

/// Covariance of `draw()`, about a mean.
template <typename Draw>
Eigen::Matrix3d MonteCarlo(const Pose2& mean, Draw draw) {
  constexpr int kDraws = 40000;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Pose2 pose = draw();
    const Eigen::Vector3d d(pose.x - mean.x, pose.y - mean.y, WrapAngle(pose.yaw - mean.yaw));
    sum += d * d.transpose() / kDraws;
  }
  return sum;
}

/// Every entry within a part of the product of the two deviations.
void ExpectCovariance(const Eigen::Matrix3d& actual,
                      const Eigen::Matrix3d& expected,
                      double tolerance) {
  const Eigen::Vector3d scale = expected.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d difference = scale.asDiagonal() * (actual - expected) * scale.asDiagonal();
  EXPECT_LT(difference.cwiseAbs().maxCoeff(), tolerance) << actual << "\n\n" << expected;
}

class Normal3 {
 public:
  Normal3(const Eigen::Matrix3d& covariance, unsigned seed)
      : root_(covariance.llt().matrixL()), random_(seed) {}
  Eigen::Vector3d operator()() {
    return root_ * Eigen::Vector3d(normal_(random_), normal_(random_), normal_(random_));
  }

 private:
  Eigen::Matrix3d root_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

TEST(ComposeCovariance, AgreesWithMonteCarlo) {
  const Pose2 T_a_b{0.7, -0.4, 1.1};
  const Pose2 T_b_c{2.0, 0.5, -0.6};
  const Eigen::Matrix3d cov_a_b = SomeCovariance(0.01, 0.02, 0.008);
  const Eigen::Matrix3d cov_b_c = SomeCovariance(0.02, 0.005, 0.01);
  Normal3 first(cov_a_b, 4);
  Normal3 second(cov_b_c, 5);
  const Eigen::Matrix3d sampled = MonteCarlo(T_a_b * T_b_c, [&] {
    const Eigen::Vector3d a = first();
    const Eigen::Vector3d b = second();
    return Pose2{T_a_b.x + a[0], T_a_b.y + a[1], T_a_b.yaw + a[2]} *
           Pose2{T_b_c.x + b[0], T_b_c.y + b[1], T_b_c.yaw + b[2]};
  });
  ExpectCovariance(ComposeCovariance(T_a_b, cov_a_b, T_b_c, cov_b_c), sampled, 0.03);
}

TEST(ComposeCovariance, ByHand) {
  // An error in yaw moves what is 3 m ahead sideways.
  Eigen::Matrix3d yaw_only = Eigen::Matrix3d::Zero();
  yaw_only(2, 2) = 1e-4;
  const Eigen::Matrix3d c = ComposeCovariance({}, yaw_only, {3, 0, 0}, Eigen::Matrix3d::Zero());
  EXPECT_NEAR(c(0, 0), 0, 1e-15);
  EXPECT_NEAR(c(1, 1), 9e-4, 1e-15);
  EXPECT_NEAR(c(1, 2), 3e-4, 1e-15);
  EXPECT_NEAR(c(2, 2), 1e-4, 1e-15);
}

TEST(BaseMotionCovariance, AgreesWithMonteCarlo) {
  const CeilingView view = OffsetView();
  const ImageMotion motion{60, -140, 0.7, 1};
  const Eigen::Matrix3d covariance = SomeCovariance(0.3, 0.2, 0.002);
  Normal3 draw(covariance, 6);
  const Eigen::Matrix3d sampled = MonteCarlo(BaseMotion(view, motion), [&] {
    const Eigen::Vector3d d = draw();
    return BaseMotion(view, {motion.tx_px + d[0], motion.ty_px + d[1], motion.theta_rad + d[2], 1});
  });
  ExpectCovariance(BaseMotionCovariance(view, motion, covariance), sampled, 0.03);
}

/// Of robots whose ceiling was seen without error, but whose tilts are not what they were taken
/// for: the error of the foot's position compared with its covariance.
TEST(InflateTiltCovariance, AgreesWithMonteCarlo) {
  const CeilingView view = OffsetView();
  const calib::LevelView level_view(view);
  Tilt tilt{0.05, -0.03, 0, {}};
  tilt.covariance << 4e-6, 1.5e-6, 1.5e-6, 1e-6;
  graph::Edge edge;
  edge.T_from_to = {0.3, -0.2, 0.8};
  edge.information = Eigen::Vector3d(1e12, 1e12, 1e6).asDiagonal();
  InflateTiltCovariance(view, tilt, edge);
  const Eigen::Matrix3d claimed = edge.information.inverse();
  EXPECT_NEAR(claimed(2, 2), 1e-6, 1e-12);
  EXPECT_NEAR(claimed(0, 2), 0, 1e-12);

  std::mt19937 random(12);
  std::normal_distribution<double> normal;
  const Eigen::Matrix2d root = tilt.covariance.llt().matrixL();
  const Pose2 seen = level_view.Uncompensated(edge.T_from_to, tilt);
  constexpr int kRuns = 20000;
  Eigen::Matrix2d sampled = Eigen::Matrix2d::Zero();
  for (int i = 0; i < kRuns; ++i) {
    const Eigen::Vector2d off = root * Eigen::Vector2d(normal(random), normal(random));
    Tilt taken = tilt;
    taken.pitch_rad += off[0];
    taken.roll_rad += off[1];
    const Eigen::Vector2d shift = level_view.CeilingShift(taken);
    const Pose2 foot = seen * Pose2{-shift.x(), -shift.y(), 0};
    const Eigen::Vector2d error = foot.Translation() - edge.T_from_to.Translation();
    sampled += error * error.transpose() / kRuns;
  }
  EXPECT_LT((sampled - claimed.topLeftCorner<2, 2>()).norm(), 0.04 * sampled.norm())
      << sampled << "\n\n"
      << claimed;
}

TEST(InflateTiltCovariance, MatchesAManualResultAndIsZeroWithoutUncertainty) {
  // A pitch that is wrong by 0.01 rad under a ceiling of 2.6 m, of a robot that faces y.
  const CeilingView view = OffsetView();
  graph::Edge edge;
  edge.T_from_to = {1, 2, kPi / 2};
  edge.information.setIdentity();
  Tilt tilt;
  InflateTiltCovariance(view, tilt, edge);
  EXPECT_EQ(edge.information, Eigen::Matrix3d::Identity());
  tilt.covariance(0, 0) = 1e-4;
  InflateTiltCovariance(view, tilt, edge);
  EXPECT_NEAR(edge.information(0, 0), 1, 1e-12);
  EXPECT_NEAR(1 / edge.information(1, 1), 1 + 0.026 * 0.026, 1e-12);
  EXPECT_NEAR(edge.information(2, 2), 1, 1e-12);
}

TEST(Interpolate, TwoHalvesMakeTheWhole) {
  std::mt19937 random(7);
  for (int i = 0; i < 100; ++i) {
    const Pose2 T = RandomPose(random);
    const Pose2 half = Interpolate(T, 0.5);
    const Pose2 whole = half * half;
    ExpectPose(whole, T.x, T.y, T.yaw, 1e-9);
    ExpectPose(Interpolate(T, 1), T.x, T.y, T.yaw, 1e-9);
    ExpectPose(Interpolate(T, 0), 0, 0, 0, 1e-12);
    const Pose2 back = Interpolate(T, -1);
    ExpectPose(T * back, 0, 0, 0, 1e-9);
    const Pose2 twice = T * T;
    ExpectPose(Interpolate(T, 2), twice.x, twice.y, twice.yaw, 1e-9);
  }
}

TEST(Interpolate, StraightAndNearlyStraight) {
  ExpectPose(Interpolate({1, 2, 0}, 0.25), 0.25, 0.5, 0);
  for (const double yaw : {1e-9, 1e-5, 9e-5, 1.1e-4, 1e-3}) {
    const Pose2 half = Interpolate({1, 2, yaw}, 0.5);
    const Pose2 whole = half * half;
    ExpectPose(whole, 1, 2, yaw, 1e-11);
  }
}

TEST(Interpolate, AQuarterCircleByHand) {
  // A quarter circle of radius 1 to the left; half of it ends at 45 degrees.
  const Pose2 half = Interpolate({1, 1, kPi / 2}, 0.5);
  ExpectPose(half, std::sin(kPi / 4), 1 - std::cos(kPi / 4), kPi / 4);
}

}  // namespace
}  // namespace ceilmap::mapping
