#include "mapping/registration/depth_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <vector>

#include "calib/base/degrees.hpp"
#include "tests/mapping/registration/shared_errors.hpp"

namespace ceilmap::registration {
namespace {

const PlaneCamera kCamera{400, {3, -2}};

/// Blocks on a grid, every third one at 1.4 times the inverse height.
std::vector<PlaneShift> Shifts(const PlaneMotion& motion, double noise_px, double known_sigma) {
  std::mt19937 generator(5);
  std::normal_distribution<double> noise(0, noise_px);
  std::vector<PlaneShift> shifts;
  for (int i = 0; i < 120; ++i) {
    PlaneShift shift;
    shift.index = i;
    shift.block.point = {-270.0 + 45 * (i % 12), -180.0 + 40 * (i / 12)};
    shift.block.peak = 0.9;
    const double rho = i % 3 == 0 ? 1.4 : 1;
    shift.seen = motion.Apply(kCamera, shift.block.point, rho) +
                 Eigen::Vector2d(noise(generator), noise(generator));
    shift.current_from_reference = motion.Jacobian(kCamera, shift.block.point, rho);
    shift.rho = known_sigma < 0.1 ? rho : 1.15;
    shift.rho_sigma = known_sigma;
    shifts.push_back(shift);
  }
  return shifts;
}

TEST(DepthFit, KnownHeightsGiveTheMotion) {
  const PlaneMotion truth{0.1, -0.05, 0, 0.08, 0, 0};
  const DepthFit fit = FitDepthMotion(kCamera, Shifts(truth, 0.1, 0.005), {0.09, -0.04, 0, 0.07});
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(fit.motion.x, truth.x, 1e-4);
  EXPECT_NEAR(fit.motion.y, truth.y, 1e-4);
  EXPECT_NEAR(fit.motion.yaw, truth.yaw, 1e-4);
  EXPECT_EQ(fit.inliers, 120);
  const double sigma = std::sqrt(fit.covariance(0, 0));
  EXPECT_GT(sigma, 1e-5);
  EXPECT_LT(sigma, 1e-3);
}

TEST(DepthFit, UnknownHeightsGiveRotationAndDirectionOnly) {
  const PlaneMotion truth{0.1, 0, 0, 0.08, 0, 0};
  const DepthFit fit = FitDepthMotion(kCamera, Shifts(truth, 0.1, 0.25), {0.09, 0.01, 0, 0.07});
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(fit.motion.yaw, truth.yaw, 2e-4);
  EXPECT_NEAR(fit.motion.y, 0, 2e-4);
  // The length is that at which the heights are those that were assumed, and as uncertain.
  EXPECT_GT(std::sqrt(fit.covariance(0, 0)), 10 * std::sqrt(fit.covariance(1, 1)));
  EXPECT_NEAR(fit.motion.x, truth.x, 4 * std::sqrt(fit.covariance(0, 0)));
  for (std::size_t i = 0; i < fit.blocks.size(); ++i) {
    const double rho = i % 3 == 0 ? 1.4 : 1;
    EXPECT_NEAR(fit.blocks[i].rho * fit.motion.x, rho * truth.x, 3e-3) << i;
  }
}

TEST(DepthFit, ABlockThatMovesAcrossTheTravelIsAnOutlier) {
  const PlaneMotion truth{0.1, 0, 0, 0, 0, 0};
  std::vector<PlaneShift> shifts = Shifts(truth, 0.05, 0.25);
  shifts[50].seen += Eigen::Vector2d(0, 4);   // moves by itself
  shifts[52].seen += Eigen::Vector2d(-4, 0);  // is nearer
  const DepthFit fit = FitDepthMotion(kCamera, shifts, truth);
  ASSERT_TRUE(fit.ok);
  EXPECT_FALSE(fit.blocks[50].inlier);
  EXPECT_TRUE(fit.blocks[52].inlier);
  EXPECT_NEAR(fit.motion.y, 0, 2e-4);
}

TEST(DepthFit, AnEdgeAcrossTheTravelIsNoEvidenceWhereItsHeightIsUnknown) {
  const PlaneMotion truth{0.1, 0, 0, 0, 0, 0};
  std::vector<PlaneShift> shifts = Shifts(truth, 0.05, 0.25);
  shifts[7].block.sharpness << 1, 0, 0, 0;  // determined along the travel only
  shifts[8].block.sharpness << 0, 0, 0, 1;
  const DepthFit fit = FitDepthMotion(kCamera, shifts, truth);
  ASSERT_TRUE(fit.ok);
  EXPECT_LT(fit.blocks[7].evidence, 0.1);
  EXPECT_GT(fit.blocks[8].evidence, 0.9);
}

TEST(DepthFit, DepthIsNotTiltAndATiltIsMeasured) {
  DepthFitParams params;
  params.fit_tilt = true;
  PlaneMotion truth{0.1, -0.05, 0, 0.08, 0, 0};
  DepthFit fit = FitDepthMotion(kCamera, Shifts(truth, 0.1, 0.005), truth, params);
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(fit.motion.tilt_x, 0, 4 * std::sqrt(fit.covariance(4, 4)));
  EXPECT_NEAR(fit.motion.tilt_y, 0, 4 * std::sqrt(fit.covariance(5, 5)));
  truth.tilt_x = 3 * kRadPerDeg;
  truth.tilt_y = -1 * kRadPerDeg;
  truth.height = 0.004;
  fit = FitDepthMotion(kCamera, Shifts(truth, 0.1, 0.005), {0.09, -0.05, 0, 0.07}, params);
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(fit.motion.tilt_x, truth.tilt_x, 5e-4);
  EXPECT_NEAR(fit.motion.tilt_y, truth.tilt_y, 5e-4);
  EXPECT_NEAR(fit.motion.height, truth.height, 3e-4);
}

TEST(DepthFit, AKnownMotionIsKept) {
  const PlaneMotion truth{0.1, 0, 0, 0, 0, 0};
  DepthFitParams params;
  params.fit_motion = false;
  const DepthFit fit = FitDepthMotion(kCamera, Shifts(truth, 0.05, 0.25), truth, params);
  ASSERT_TRUE(fit.ok);
  EXPECT_EQ(fit.motion.x, truth.x);
  EXPECT_TRUE(fit.covariance.isZero());
  EXPECT_NEAR(fit.blocks[3].rho, 1.4, 0.01);
  EXPECT_NEAR(fit.blocks[4].rho, 1.0, 0.01);
}

// Heights that are known to 1 %, and heights of which nothing is known: blocks of 32 px that
// overlap, with errors of the heights of their own.
TEST(DepthFit, CovarianceHoldsTheErrors) {
  constexpr int kDraws = 300;
  constexpr double kNoisePx = 0.1;
  const SharedNoise shared = SharedByBlocks(32);
  std::vector<Eigen::Vector2d> points;
  for (int k = 0; k < 120; ++k) points.emplace_back(-110.0 + 20 * (k % 12), -90.0 + 20 * (k / 12));
  const SharedErrors errors(points, shared);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> normal;
  for (const double rho_sigma : {0.0, 0.01, 0.1}) {
    for (const bool tilts : {false, true}) {
      DepthFitParams params;
      params.fit_tilt = tilts;
      const std::vector<int> fitted =
          tilts ? std::vector<int>{0, 1, 2, 3, 4, 5} : std::vector<int>{0, 1, 3};
      double nees = 0;
      for (int draw = 0; draw < kDraws; ++draw) {
        PlaneMotion truth{0.1 * unit(random), 0.1 * unit(random), 0, 0.3 * unit(random), 0, 0};
        if (tilts) truth.tilt_x = 3 * kRadPerDeg * unit(random);
        const Eigen::MatrixXd noise = kNoisePx * errors.Draw(random);
        std::vector<PlaneShift> shifts(points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
          PlaneShift& s = shifts[i];
          s.block.point = points[i];
          s.rho = i % 3 == 0 ? 1.4 : 1;
          s.rho_sigma = rho_sigma;
          const double rho = s.rho + rho_sigma * normal(random);
          s.current_from_reference = truth.Jacobian(kCamera, points[i], s.rho);
          s.seen = truth.Apply(kCamera, points[i], rho) +
                   s.current_from_reference * noise.row(static_cast<Eigen::Index>(i)).transpose();
        }
        const DepthFit fit = FitDepthMotion(kCamera, shifts, truth, params, &shared);
        ASSERT_TRUE(fit.ok);
        Eigen::Matrix<double, 6, 1> error;
        error << fit.motion.x - truth.x, fit.motion.y - truth.y, fit.motion.height - truth.height,
            fit.motion.yaw - truth.yaw, fit.motion.tilt_x - truth.tilt_x,
            fit.motion.tilt_y - truth.tilt_y;
        nees += NeesOf(error(fitted), fit.covariance(fitted, fitted)) / kDraws;
      }
      // The scale of the residuals contains a part of unknown heights.
      EXPECT_GT(nees, rho_sigma > 0 ? 0.6 : 0.75) << rho_sigma << tilts;
      EXPECT_LT(nees, 1.3) << rho_sigma << tilts;
    }
  }
}

TEST(DepthFit, TooFewBlocks) {
  std::vector<PlaneShift> shifts = Shifts({0.1, 0, 0, 0, 0, 0}, 0.1, 0.01);
  shifts.resize(5);
  EXPECT_FALSE(FitDepthMotion(kCamera, shifts, {}).ok);
}

}  // namespace
}  // namespace ceilmap::registration
