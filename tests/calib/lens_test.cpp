#include "calib/lens.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <random>

namespace ceilmap::calib {
namespace {

constexpr double kHalfCircle = std::numbers::pi;

Lens MakeCamera() {
  Lens camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx = 457;
  camera.fy = 460;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
}

TEST(Lens, ProjectsByHand) {
  // 0.5 m right and 0.2 m down at 2 m: 457 * 0.25 right, 460 * 0.1 down of the principal point.
  const auto pixel = MakeCamera().Project({0.5, 0.2, 2});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), 319.5 + 114.25, 1e-12);
  EXPECT_NEAR(pixel->y(), 239.5 + 46, 1e-12);
}

TEST(Lens, BarrelDistortionPullsInwards) {
  Lens camera = MakeCamera();
  EXPECT_FALSE(camera.IsDistorted());
  camera.distortion[0] = -0.1;
  EXPECT_TRUE(camera.IsDistorted());
  // x/z = 0.5: 0.5 (1 - 0.1 * 0.25) = 0.4875.
  EXPECT_NEAR(camera.Project({1, 0, 2})->x(), 319.5 + 457 * 0.4875, 1e-12);
}

TEST(Lens, AgreesWithOpenCv) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> slope(-0.8, 0.8);
  std::uniform_real_distribution<double> depth(0.5, 5);
  Lens camera = MakeCamera();
  camera.distortion = {-0.12, 0.02, 0.001, -0.002, 0.003};
  for (int i = 0; i < 500; ++i) {
    const double z = depth(random);
    const Eigen::Vector3d p(slope(random) * z, slope(random) * z, z);
    std::vector<cv::Point2d> expected;
    cv::projectPoints(std::vector<cv::Point3d>{{p.x(), p.y(), p.z()}},
                      cv::Vec3d(),
                      cv::Vec3d(),
                      camera.Matrix(),
                      camera.Coefficients(),
                      expected);
    const auto pixel = camera.Project(p);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), expected[0].x, 1e-9);
    EXPECT_NEAR(pixel->y(), expected[0].y, 1e-9);
  }
}

TEST(Lens, ShowsNothingBehindItself) {
  EXPECT_FALSE(MakeCamera().Project({0.1, 0.1, 0}));
  EXPECT_FALSE(MakeCamera().Project({0.1, 0.1, -1}));
}

TEST(Lens, RefusesRaysWhereTheModelFoldsBack) {
  Lens camera = MakeCamera();
  camera.distortion[0] = -0.3;  // slope 1 - 0.9 r^2: grows up to r = 1.0541
  EXPECT_TRUE(camera.Project({1.05, 0, 1}));
  EXPECT_FALSE(camera.Project({1.06, 0, 1}));
  EXPECT_FALSE(camera.Project({3, 0, 1}));
  // Falls between r^2 = 0.5 and 1, grows again beyond: (1 - s / 0.5) (1 - s) = 1 - 3 s + 2 s^2.
  camera.distortion = {-1, 0.4, 0, 0, 0};
  EXPECT_TRUE(camera.Project({0.7, 0, 1}));
  EXPECT_FALSE(camera.Project({0.72, 0, 1}));
  EXPECT_FALSE(camera.Project({2, 0, 1}));
}

Lens Rational() {
  Lens lens = MakeCamera();
  lens.model = LensModel::kRational;
  lens.distortion = {0.2, -0.01, 0.001, -0.002, 0.001, 0.4, 0.01, 0.001};
  return lens;
}

Lens Fisheye() {
  Lens lens = MakeCamera();
  lens.fx = 200;
  lens.fy = 201;
  lens.model = LensModel::kEquidistant;
  lens.distortion = {0.05, -0.01, 0.002, -0.0003};
  return lens;
}

TEST(Lens, RationalAgreesWithOpenCv) {
  const Lens lens = Rational();
  const std::vector<cv::Point3d> points = {{0.1, 0.2, 1}, {-0.9, 0.3, 1}, {1.5, -1.4, 2}};
  std::vector<cv::Point2d> expected;
  cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), lens.Matrix(), lens.Coefficients(), expected);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = lens.Project({points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), expected[i].x, 1e-9);
    EXPECT_NEAR(pixel->y(), expected[i].y, 1e-9);
  }
}

TEST(Lens, FisheyeAgreesWithOpenCv) {
  const Lens lens = Fisheye();
  const std::vector<cv::Point3d> points = {{0, 0, 1}, {0.1, 0.2, 1}, {-3, 0.3, 1}, {5, -4, 0.5}};
  std::vector<cv::Point2d> expected;
  cv::fisheye::projectPoints(
      points, expected, cv::Vec3d(), cv::Vec3d(), lens.Matrix(), lens.Coefficients());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = lens.Project({points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), expected[i].x, 1e-9);
    EXPECT_NEAR(pixel->y(), expected[i].y, 1e-9);
  }
}

TEST(Lens, AFisheyeShowsWhatIsBesideAndBehindIt) {
  Lens lens = Fisheye();
  lens.distortion = {};
  // 90 and 120 degrees to the right: theta = pi / 2 and 2 pi / 3.
  EXPECT_NEAR(lens.Project({1, 0, 0})->x(), 319.5 + 200 * kHalfCircle / 2, 1e-9);
  EXPECT_NEAR(lens.Project({std::sqrt(3.0), 0, -1})->x(), 319.5 + 200 * 2 * kHalfCircle / 3, 1e-9);
  EXPECT_FALSE(lens.Project({0, 0, -1}));
  EXPECT_NEAR(lens.ValidAngle(), kHalfCircle, 1e-12);
  lens.distortion[0] = -0.1;  // slope 1 - 0.3 theta^2
  EXPECT_NEAR(lens.ValidAngle(), std::sqrt(1 / 0.3), 1e-9);
  EXPECT_TRUE(lens.Project({std::sin(1.82), 0, std::cos(1.82)}));
  EXPECT_FALSE(lens.Project({std::sin(1.83), 0, std::cos(1.83)}));
  EXPECT_FALSE(lens.Ray({319.5 + 200 * 1.83, 239.5}));
}

TEST(Lens, IsValidUpToItsFoldOrPole) {
  Lens lens = MakeCamera();
  EXPECT_NEAR(lens.ValidAngle(), kHalfCircle / 2, 1e-12);
  lens.distortion[0] = -0.1;  // r - 0.1 r^3 has its maximum at r = sqrt(10 / 3)
  EXPECT_NEAR(lens.ValidAngle(), std::atan(std::sqrt(10.0 / 3)), 1e-9);
  EXPECT_NEAR(lens.Radius(lens.ValidAngle()), std::sqrt(10.0 / 3) * 2 / 3, 1e-9);
  lens.model = LensModel::kRational;
  lens.distortion = {0, 0, 0, 0, 0, -0.25};  // r / (1 - r^2 / 4)
  EXPECT_NEAR(lens.ValidAngle(), std::atan(2.0), 1e-9);
  EXPECT_TRUE(lens.Project({1.99, 0, 1}));
  EXPECT_FALSE(lens.Project({2.01, 0, 1}));
}

// Random lenses of each model: the ray of a pixel appears in it, and the pixel of a ray has it.
TEST(Lens, RaysAndPixelsAreInverse) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> one(-1, 1);
  int rays = 0;
  for (int i = 0; i < 300; ++i) {
    Lens lens = MakeCamera();
    lens.model = static_cast<LensModel>(i % 3);
    lens.distortion = {0.2 * one(random),
                       0.05 * one(random),
                       0.005 * one(random),
                       0.005 * one(random),
                       0.01 * one(random)};
    if (lens.model == LensModel::kRational) lens.distortion[5] = 0.3 * one(random);
    if (lens.model == LensModel::kEquidistant) {
      lens.fx = lens.fy = 150 + 100 * one(random);
      lens.distortion = {0.06 * one(random), 0.01 * one(random), 0.002 * one(random)};
    }
    const double valid_angle = lens.ValidAngle();
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector2d pixel(319.5 + 319.5 * one(random), 239.5 + 239.5 * one(random));
      const auto ray = lens.Ray(pixel);
      if (!ray) continue;
      ++rays;
      EXPECT_NEAR(ray->norm(), 1, 1e-12);
      EXPECT_LT(std::acos(ray->z()), valid_angle + 1e-9);
      const auto again = lens.Project(*ray);
      ASSERT_TRUE(again);
      EXPECT_LT((*again - pixel).norm(), 1e-7);
    }
    const double angle = 0.95 * valid_angle * std::abs(one(random));
    if (lens.model == LensModel::kEquidistant || angle < 0.9) {
      EXPECT_NEAR(lens.Angle(lens.Radius(angle)).value(), angle, 1e-9);
    }
  }
  EXPECT_GT(rays, 5000);
}

TEST(Lens, DerivativesAreThoseOfTheProjection) {
  for (Lens lens : {MakeCamera(), Rational(), Fisheye()}) {
    const Eigen::Vector3d p(0.3, -0.2, 0.6);
    const ProjectionDerivatives d = ProjectWithDerivatives(lens, p);
    EXPECT_LT((d.pixel - lens.Project(p).value()).norm(), 1e-9);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector2d change =
          (lens.Project(p + step).value() - lens.Project(p - step).value()) / (2 * kStep);
      EXPECT_LT((d.by_point.col(i) - change).norm(), 1e-5) << i;
    }
    const Eigen::VectorXd values = lens.Values();
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      lens.SetValues(values + kStep * Eigen::VectorXd::Unit(values.size(), i));
      const Eigen::Vector2d change = (lens.Project(p).value() - d.pixel) / kStep;
      EXPECT_LT((d.by_lens.col(i) - change).norm(), 1e-3) << i;
      lens.SetValues(values);
    }
  }
}

}  // namespace
}  // namespace ceilmap::calib
