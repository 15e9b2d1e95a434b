#include "mapping/registration/plane_motion.hpp"
#include "calib/base/degrees.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "mapping/registration/motion_covariance.hpp"
#include "mapping/registration/plane_projection.hpp"
#include "mapping/registration/registrar.hpp"
#include "tests/mapping/registration/shared_errors.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {
const PlaneCamera kPlaneCamera{457, {3, -2}};

PlaneMotion RandomPlaneMotion(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  return {0.2 * unit(random),
          0.2 * unit(random),
          0.05 * unit(random),
          0.5 * unit(random),
          4 * kRadPerDeg * unit(random),
          4 * kRadPerDeg * unit(random)};
}

/// The same by rays: the pixel's point on the plane, brought to the current camera.
Eigen::Vector2d ByRays(const PlaneMotion& m, const Eigen::Vector2d& x) {
  const Eigen::Vector3d p_ref =
      ((x - kPlaneCamera.principal_px) / kPlaneCamera.focal_px).homogeneous();
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(m.yaw, Eigen::Vector3d::UnitZ()) *
                             Eigen::AngleAxisd(m.tilt_y, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(m.tilt_x, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  const Eigen::Vector3d p_cur = R.transpose() * (p_ref - Eigen::Vector3d(m.x, m.y, m.height));
  return kPlaneCamera.focal_px * p_cur.hnormalized() + kPlaneCamera.principal_px;
}

TEST(PlaneMotion, AppliesLikeRays) {
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    const PlaneMotion motion = RandomPlaneMotion(random);
    const Eigen::Vector2d x(12.0 * i - 300, 230 - 9.0 * i);
    EXPECT_LT((motion.Apply(kPlaneCamera, x) - ByRays(motion, x)).norm(), 1e-9);
  }
}

/// Beside the mast, turned, its principal point off the centre.
calib::CeilingView OddView() {
  calib::MountedCamera up;
  up.camera = {320, 240, 220, 220, 150, 128, {}};
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(70 * kRadPerDeg, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0.12, -0.07, 0.4);
  return {up, 2.6};
}

TEST(PlaneCamera, OfAViewHasItsPrincipalPointFromTheCentre) {
  const PlaneCamera camera = PlaneCameraOf(OddView());
  EXPECT_DOUBLE_EQ(camera.focal_px, 220);
  EXPECT_NEAR((camera.principal_px - Eigen::Vector2d(-9.5, 8.5)).norm(), 0, 1e-9);
}

// A rotation of a robot in space, in its camera's frame.
TEST(PlaneFit, TiltIsThatOfTheRobot) {
  const calib::CeilingView view = OddView();
  const Eigen::Matrix3d R_base_camera = view.T_base_camera().linear();
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const Tilt tilt{4 * kRadPerDeg * unit(random), 4 * kRadPerDeg * unit(random), 0, {}};
    const Eigen::Isometry3d T = ToSpace({0, 0, 0.5 * unit(random)}, tilt);
    Eigen::Isometry3d T_camera = Eigen::Isometry3d::Identity();
    T_camera.linear() = R_base_camera.transpose() * T.linear() * R_base_camera;
    const PlanarTilt seen = FromSpace(T_camera);
    PlaneFit fit;
    fit.motion.tilt_x = seen.tilt.roll_rad;
    fit.motion.tilt_y = seen.tilt.pitch_rad;
    const Eigen::Vector2d angles = TiltOf(fit, view).angles;
    EXPECT_NEAR(angles[0], tilt.pitch_rad, 0.01 * kRadPerDeg);
    EXPECT_NEAR(angles[1], tilt.roll_rad, 0.01 * kRadPerDeg);
  }
}

// The covariance turns with the angles: a camera with a small variance about one axis only.
TEST(PlaneFit, TiltCovarianceTurnsWithTheCamera) {
  const calib::CeilingView view = OddView();
  for (const Eigen::Vector2d& direction : {Eigen::Vector2d(1, 0), Eigen::Vector2d(0.6, -0.8)}) {
    PlaneFit fit;
    fit.motion.tilt_x = 1e-3 * direction.x();
    fit.motion.tilt_y = 1e-3 * direction.y();
    fit.covariance.bottomRightCorner<2, 2>() = 1e-6 * direction * direction.transpose();
    const TiltAngles tilt = TiltOf(fit, view);
    EXPECT_NEAR(tilt.angles.norm(), 1e-3, 1e-12);
    EXPECT_LT((tilt.covariance - tilt.angles * tilt.angles.transpose()).norm(), 1e-15);
  }
}

TEST(PlaneMotion, JacobianIsTheDerivative) {
  std::mt19937 random(2);
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 20; ++i) {
    const PlaneMotion motion = RandomPlaneMotion(random);
    const Eigen::Vector2d x(30.0 * i - 300, 230 - 22.0 * i);
    const Eigen::Matrix2d jacobian = motion.Jacobian(kPlaneCamera, x);
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(k);
      const Eigen::Vector2d slope =
          (motion.Apply(kPlaneCamera, x + step) - motion.Apply(kPlaneCamera, x - step)) /
          (2 * kStep);
      EXPECT_LT((jacobian.col(k) - slope).norm(), 1e-6);
    }
  }
}

TEST(PlaneMotion, OneDegreeOfTiltMovesTheBorderByFourPixels) {
  // The example of compensation/README.md, "Tilt from the ceiling": f = 457 px, 320 px off centre.
  PlaneMotion motion;
  motion.tilt_y = kRadPerDeg;
  const PlaneCamera camera{457, {0, 0}};
  const double centre = motion.Apply(camera, {0, 0}).x();
  EXPECT_NEAR(std::abs(motion.Apply(camera, {320, 0}).x() - 320 - centre), 3.9, 0.2);
}

TEST(PlaneMotion, FromSimilarityMovesPixelsEqually) {
  for (const ImageMotion& motion : {ImageMotion{30, -20, 0.4, 1}, ImageMotion{-5, 60, -2, 1.1}}) {
    const PlaneMotion plane = PlaneMotion::FromSimilarity(kPlaneCamera, motion);
    EXPECT_EQ(plane.tilt_x, 0);
    EXPECT_EQ(plane.tilt_y, 0);
    for (const Eigen::Vector2d& x :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(300, -200), Eigen::Vector2d(-100, 150)}) {
      EXPECT_LT((plane.Apply(kPlaneCamera, x) - motion.Apply(x)).norm(), 1e-9);
    }
  }
}

/// Blocks of a 640x480 image, where `truth` and some noise show them.
std::vector<PlaneShift> Shifts(const PlaneMotion& truth, double noise_px) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<PlaneShift> shifts;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 8; ++i) {
      PlaneShift s;
      s.block.point = {72.0 * i - 252, 72.0 * j - 180};
      s.block.peak = 0.8;
      s.seen = truth.Apply(kPlaneCamera, s.block.point) +
               noise_px * Eigen::Vector2d(normal(random), normal(random));
      s.current_from_reference = truth.Jacobian(kPlaneCamera, s.block.point);
      shifts.push_back(s);
    }
  }
  return shifts;
}

using Six = Eigen::Matrix<double, 6, 1>;
Six Difference(const PlaneMotion& a, const PlaneMotion& b) {
  Six d;
  d << a.x - b.x, a.y - b.y, a.height - b.height, a.yaw - b.yaw, a.tilt_x - b.tilt_x,
      a.tilt_y - b.tilt_y;
  return d;
}

TEST(FitPlaneMotion, ExactMotions) {
  std::mt19937 random(4);
  for (int i = 0; i < 10; ++i) {
    const PlaneMotion truth = RandomPlaneMotion(random);
    PlaneMotion start = truth;
    start.x += 0.004;
    start.yaw -= 0.005;
    start.tilt_x += 0.01;
    const PlaneFit fit = FitPlaneMotion(kPlaneCamera, Shifts(truth, 0), start);
    ASSERT_TRUE(fit.ok);
    EXPECT_LT(Difference(fit.motion, truth).cwiseAbs().maxCoeff(), 1e-7) << i;
    EXPECT_EQ(fit.inliers, 48);
  }
}

TEST(FitPlaneMotion, LampsBelowTheCeilingDropOut) {
  const PlaneMotion truth{0.1, -0.05, 0.01, 0.2, 2 * kRadPerDeg, -kRadPerDeg};
  auto shifts = Shifts(truth, 0.02);
  for (std::size_t i = 0; i < shifts.size(); i += 6) shifts[i].seen += Eigen::Vector2d(6, 3);
  const PlaneFit fit = FitPlaneMotion(kPlaneCamera, shifts, truth);
  ASSERT_TRUE(fit.ok);
  EXPECT_EQ(fit.inliers, 40);
  EXPECT_LT(std::abs(fit.motion.tilt_x - truth.tilt_x), 0.02 * kRadPerDeg);
  EXPECT_LT(std::abs(fit.motion.tilt_y - truth.tilt_y), 0.02 * kRadPerDeg);
  const Six d = Difference(fit.motion, truth);
  EXPECT_LT(d.dot(fit.covariance.ldlt().solve(d)), 36) << "six sigmas";
}

TEST(FitPlaneMotion, HoldsFixedParameters) {
  const PlaneMotion truth{0.1, -0.05, 0, 0.2, 0, 0};
  PlaneFitParams params;
  params.fit_height = false;
  params.fit_tilt = false;
  const SharedNoise nothing;
  const PlaneFit fit = FitPlaneMotion(kPlaneCamera, Shifts(truth, 0.02), truth, params, &nothing);
  ASSERT_TRUE(fit.ok);
  EXPECT_EQ(fit.motion.height, 0);
  EXPECT_EQ(fit.motion.tilt_x, 0);
  EXPECT_EQ(fit.motion.tilt_y, 0);
  for (const int held : {2, 4, 5}) EXPECT_EQ(fit.covariance.row(held).norm(), 0) << held;
  for (const int free : {0, 1, 3}) EXPECT_GT(fit.covariance(free, free), 0) << free;
}

TEST(FitPlaneMotion, TooFewBlocksAreNotOk) {
  auto shifts = Shifts({}, 0);
  shifts.resize(5);
  EXPECT_FALSE(FitPlaneMotion(kPlaneCamera, shifts, {}).ok);
  EXPECT_FALSE(FitPlaneMotion(kPlaneCamera, {}, {}).ok);
}

// Blocks of 64 px that overlap, on small and on larger images.
TEST(FitPlaneMotion, CovarianceHoldsWhereBlocksShareNoise) {
  constexpr int kDraws = 500;
  constexpr double kNoisePx = 0.05;
  const SharedNoise shared = SharedByBlocks(64);
  std::mt19937 random(7);
  for (const double step_px : {26.0, 36.0, 70.0}) {
    std::vector<Eigen::Vector2d> points;
    for (int k = 0; k < 48; ++k)
      points.emplace_back(step_px * (k % 8 - 3.5), step_px * (k / 8 - 3));
    const SharedErrors errors(points, shared);
    double nees = 0;
    double tilt = 0;
    double as_independent = 0;
    for (int draw = 0; draw < kDraws; ++draw) {
      const PlaneMotion truth = RandomPlaneMotion(random);
      const Eigen::MatrixXd noise = kNoisePx * errors.Draw(random);
      std::vector<PlaneShift> shifts(points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        PlaneShift& s = shifts[i];
        s.block.point = points[i];
        s.block.quality = 1 + 0.2 * static_cast<double>(i % 7);
        s.current_from_reference = truth.Jacobian(kPlaneCamera, points[i]);
        const Eigen::Vector2d error = noise.row(static_cast<Eigen::Index>(i)).transpose();
        s.seen = truth.Apply(kPlaneCamera, points[i]) +
                 s.current_from_reference * error / std::sqrt(s.block.quality);
      }
      const PlaneFit fit = FitPlaneMotion(kPlaneCamera, shifts, truth, {}, &shared);
      ASSERT_TRUE(fit.ok);
      const Six error = Difference(fit.motion, truth);
      nees += NeesOf(error, fit.covariance) / kDraws;
      tilt += NeesOf(error.tail<2>(), fit.covariance.bottomRightCorner<2, 2>()) / kDraws;
      as_independent += NeesOf(error.tail<2>(), fit.tilt_spread) / kDraws;
    }
    EXPECT_NEAR(nees, 1, 0.2) << step_px;
    EXPECT_NEAR(tilt, 1, 0.2) << step_px;
    if (step_px < 30) {
      EXPECT_GT(as_independent, 1.15 * tilt) << "what the model is there for";
    }
  }
}

TEST(FitPlaneMotion, CovarianceContainsTheErrorThatAllBlocksHave) {
  std::vector<PlaneShift> shifts = Shifts({}, 0.02);
  const SharedNoise nothing;
  const auto without = FitPlaneMotion(kPlaneCamera, shifts, {}, {}, &nothing).covariance;
  for (PlaneShift& shift : shifts) shift.block.sampling = {0.02, 0};
  const auto with = FitPlaneMotion(kPlaneCamera, shifts, {}, {}, &nothing).covariance;
  // A shift of the image is one of the camera; tilts do not shift it alone.
  EXPECT_NEAR(with(0, 0) - without(0, 0), std::pow(0.02 / kPlaneCamera.focal_px, 2), 1e-12);
  EXPECT_NEAR(with(5, 5), without(5, 5), 1e-12);
}

TEST(PlaneProjection, MeanAroundIsTheMeanOverAWindow) {
  const PlaneMotion motion{0.1, -0.05, 0.02, 0.3, 4 * kRadPerDeg, -3 * kRadPerDeg};
  const PlaneProjection<double> projection = ProjectionOf(kPlaneCamera, motion);
  const Eigen::Vector2d at(120, -80);
  constexpr double kSigma = 16;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double total = 0;
  for (int v = -64; v <= 64; ++v) {
    for (int u = -64; u <= 64; ++u) {
      const double weight = std::exp(-0.5 * (u * u + v * v) / (kSigma * kSigma));
      mean += weight * projection.Apply(at + Eigen::Vector2d(u, v));
      total += weight;
    }
  }
  mean /= total;
  EXPECT_GT((mean - projection.Apply(at)).norm(), 0.02);
  EXPECT_LT((mean - projection.MeanAround(at, kSigma)).norm(), 1e-3);
}

TEST(RefinePlane, FindsTheTiltOfARenderedImage) {
  const cv::Size size(640, 480);
  const PlaneCamera camera{457, {0, 0}};
  // A larger and finer image of the ceiling, sampled under the plane motion.
  constexpr int kFiner = 2;
  const cv::Size large(2048, 1600);
  const cv::Mat fine = synthetic::SyntheticCeiling().RenderFloat(large, {0, 0, 0, kFiner});
  const auto render = [&](const PlaneMotion& motion) {
    // Reference pixel of each current pixel: by Newton, as Apply has a derivative.
    cv::Mat image(size, CV_8UC1);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const Eigen::Vector2d seen(u - 319.5, v - 239.5);
        Eigen::Vector2d x = seen;
        for (int step = 0; step < 4; ++step) {
          x -= motion.Jacobian(camera, x).inverse() * (motion.Apply(camera, x) - seen);
        }
        const double fx = kFiner * x.x() + 0.5 * (large.width - 1);
        const double fy = kFiner * x.y() + 0.5 * (large.height - 1);
        const int ix = static_cast<int>(fx);
        const int iy = static_cast<int>(fy);
        const double px = fx - ix;
        const double py = fy - iy;
        const double upper = (1 - px) * fine.at<float>(iy, ix) + px * fine.at<float>(iy, ix + 1);
        const double lower =
            (1 - px) * fine.at<float>(iy + 1, ix) + px * fine.at<float>(iy + 1, ix + 1);
        image.at<std::uint8_t>(v, u) =
            cv::saturate_cast<std::uint8_t>((1 - py) * upper + py * lower);
      }
    }
    return image;
  };
  Registrar registrar(size);
  const FrameSpectrum reference = registrar.Analyze(render({}));
  for (const PlaneMotion& truth :
       {PlaneMotion{0.06, -0.04, 0, 0.1, 2.5 * kRadPerDeg, -1.5 * kRadPerDeg},
        PlaneMotion{-0.05, 0.02, 0.01, -0.2, -kRadPerDeg, 3 * kRadPerDeg}}) {
    const FrameSpectrum current = registrar.Analyze(render(truth));
    PlaneMotion start = truth;
    start.tilt_x = 0;
    start.tilt_y = 0;
    start.x += truth.tilt_y;  // where the tilted camera's axis meets the plane
    start.y -= truth.tilt_x;
    start.height = 0;
    const PlaneFit fit = registrar.RefinePlane(reference, current, camera, start);
    ASSERT_TRUE(fit.ok);
    EXPECT_LT(std::abs(fit.motion.tilt_x - truth.tilt_x), 0.01 * kRadPerDeg);
    EXPECT_LT(std::abs(fit.motion.tilt_y - truth.tilt_y), 0.01 * kRadPerDeg);
    EXPECT_LT(std::abs(fit.motion.yaw - truth.yaw), 0.005 * kRadPerDeg);
    // The image is curved by the tilt: in a block by 0.03 px in the mean, the same in all blocks.
    EXPECT_LT((fit.motion.Apply(camera, {0, 0}) - truth.Apply(camera, {0, 0})).norm(), 0.012);
    // 2.2 m below a ceiling, 0.5 mm.
    EXPECT_LT(std::hypot(fit.motion.x - truth.x, fit.motion.y - truth.y), 0.5e-3 / 2.2);

    // From a motion that is a pixel off, each place is found where it is.
    PlaneMotion near = truth;
    near.x += 1 / camera.focal_px;
    const std::vector<PlaneShift> places = registrar.MeasurePlane(reference, current, camera, near);
    ASSERT_GT(places.size(), 20U);
    double sum = 0;
    for (const PlaneShift& place : places) {
      sum += (place.seen - truth.Apply(camera, place.block.point)).squaredNorm();
    }
    EXPECT_LT(std::sqrt(sum / static_cast<double>(places.size())), 0.15);
  }
}

}  // namespace
}  // namespace ceilmap::registration
