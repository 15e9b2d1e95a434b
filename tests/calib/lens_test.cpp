#include "calib/lens.hpp"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <random>

namespace ceilmap::calib {
namespace {

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
                      camera.distortion,
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

}  // namespace
}  // namespace ceilmap::calib
