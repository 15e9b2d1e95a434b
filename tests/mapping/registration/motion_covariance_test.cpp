#include "mapping/registration/motion_covariance.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <random>

#include "mapping/registration/poc.hpp"
#include "mapping/registration/registrar.hpp"
#include "mapping/registration/sampling_error.hpp"
#include "tests/mapping/registration/shared_errors.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

namespace ceilmap::registration {
namespace {

constexpr double kHalfPi = std::numbers::pi / 2;
constexpr int kBlockPx = 64;

double Nees(const Eigen::Vector4d& error, const Eigen::Matrix4d& covariance, int n) {
  return NeesOf(error.head(n), covariance.topLeftCorner(n, n));
}

TEST(SharedNoise, FallsFromOneToNothing) {
  const SharedNoise shared = SharedByBlocks(kBlockPx);
  EXPECT_DOUBLE_EQ(shared.Correlation({0, 0}), 1);
  EXPECT_NEAR(shared.Correlation({32, 0}), 0.097, 1e-3) << "half a block";
  EXPECT_DOUBLE_EQ(shared.Correlation({0, -32}), shared.Correlation({32, 0}));
  EXPECT_NEAR(shared.Correlation({32, 32}), 0.097 * 0.097, 1e-3);
  EXPECT_EQ(shared.Correlation({64, 0}), 0);
  EXPECT_EQ(shared.Correlation({0, 1000}), 0);
  EXPECT_GT(shared.Correlation({8.5, 0}), shared.Correlation({9, 0}));
  EXPECT_DOUBLE_EQ(SharedByBlocks(kBlockPx, 2).Correlation({20, 8}), shared.Correlation({10, 4}));
}

TEST(AfterMotion, TurnsShiftsOfTheReferenceIntoTheCurrentImage) {
  Eigen::Matrix4d covariance = Eigen::Vector4d(4, 1, 0.01, 0.02).asDiagonal();
  covariance(0, 2) = covariance(2, 0) = 0.1;
  const Eigen::Matrix4d turned = AfterMotion({30, -7, kHalfPi, 1.5}, covariance);
  EXPECT_NEAR(turned(0, 0), 1 * 1.5 * 1.5, 1e-12);
  EXPECT_NEAR(turned(1, 1), 4 * 1.5 * 1.5, 1e-12);
  EXPECT_NEAR(turned(1, 2), 0.1 * 1.5, 1e-12);
  EXPECT_NEAR(turned(0, 2), 0, 1e-12);
  EXPECT_EQ(turned.bottomRightCorner(2, 2), covariance.bottomRightCorner(2, 2));
}

/// 6 x 4 blocks, each of which overlaps with its neighbours.
std::vector<BlockShift> OverlappingBlocks(double step_px) {
  std::vector<BlockShift> blocks;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 6; ++i) {
      BlockShift block;
      block.point = {step_px * (i - 1), step_px * (j - 1)};
      block.quality = 1 + 0.2 * static_cast<double>((5 * i + j) % 7);
      blocks.push_back(block);
    }
  }
  return blocks;
}

TEST(CovarianceOf, HoldsWhereBlocksShareNoise) {
  constexpr int kDraws = 1000;
  constexpr double kSigma = 0.08;
  const SharedNoise shared = SharedByBlocks(kBlockPx);
  for (const bool scale : {false, true}) {
    for (const double step_px : {24.0, 32.0, 70.0}) {
      std::vector<BlockShift> blocks = OverlappingBlocks(step_px);
      std::vector<Eigen::Vector2d> points;
      points.reserve(blocks.size());
      for (const BlockShift& block : blocks) points.push_back(block.point);
      const SharedErrors shared_errors(points, shared);
      std::mt19937 random(5);
      FitParams params;
      params.estimate_scale = scale;
      double nees = 0;
      double as_independent = 0;
      for (int draw = 0; draw < kDraws; ++draw) {
        const Eigen::MatrixXd errors = kSigma * shared_errors.Draw(random);
        for (std::size_t i = 0; i < blocks.size(); ++i) {
          blocks[i].shift =
              errors.row(static_cast<Eigen::Index>(i)).transpose() / std::sqrt(blocks[i].quality);
        }
        const MotionFit fit = FitRobust(blocks, params);
        ASSERT_TRUE(fit.ok);
        const Eigen::Vector4d error(
            fit.motion.tx_px, fit.motion.ty_px, fit.motion.theta_rad, std::log(fit.motion.scale));
        const int dimensions = scale ? 4 : 3;
        const Eigen::Matrix4d covariance = CovarianceOf(fit, blocks, params, shared);
        nees += Nees(error, covariance, dimensions) / kDraws;
        as_independent += Nees(error, fit.covariance, dimensions) / kDraws;
      }
      EXPECT_NEAR(nees, 1, 0.15) << step_px << scale;
      if (step_px < 30) {
        EXPECT_GT(as_independent, 1.8) << "what the model is there for";
      }
    }
  }
}

TEST(CovarianceOf, ContainsTheErrorThatAllBlocksHave) {
  std::vector<BlockShift> blocks = OverlappingBlocks(40);
  const FitParams params;
  const SharedNoise shared = SharedByBlocks(kBlockPx);
  const MotionFit fit = FitRobust(blocks, params);
  const Eigen::Matrix4d without = CovarianceOf(fit, blocks, params, shared);
  for (BlockShift& block : blocks) block.sampling = {0.02, -0.01};
  const Eigen::Matrix4d with = CovarianceOf(fit, blocks, params, shared);
  EXPECT_NEAR(with(0, 0) - without(0, 0), 0.02 * 0.02, 1e-9);
  EXPECT_NEAR(with(0, 1) - without(0, 1), -0.02 * 0.01, 1e-9);
  EXPECT_NEAR(with(2, 2), without(2, 2), 1e-12);
}

TEST(SamplingError, OfAShiftAndOfARotation) {
  const SamplingError error(TukeyWindow(kBlockPx, PocParams{}.taper));
  const Eigen::Matrix2d full = Eigen::Matrix2d::Identity();
  EXPECT_LT(error.Expected({1, 0, 10, 0, 1, -20}, full).norm(), 1e-6) << "whole pixels";
  const Eigen::Vector2d quarter = error.Expected({1, 0, 10.25F, 0, 1, -20.5F}, full);
  EXPECT_NEAR(std::abs(quarter.x()), 0.025, 1e-6);
  EXPECT_NEAR(quarter.y(), 0, 1e-6);
  const float c = std::cos(0.1F);
  const float s = std::sin(0.1F);
  EXPECT_LT(error.Expected({c, -s, 10.25F, s, c, -20.25F}, full).norm(), 1e-6)
      << "samples lie everywhere between the pixels";
  // Smoother along x: less.
  const Eigen::Matrix2d smooth = Eigen::Vector2d(0.5, 1).asDiagonal();
  EXPECT_NEAR(error.Expected({1, 0, 10.25F, 0, 1, 0}, smooth).x(), 0.5 * quarter.x(), 1e-9);
  // Turned by a right angle the current image's x is the reference's -y.
  const Eigen::Vector2d turned = error.Expected({0, -1, 80.25F, 1, 0, 4}, full);
  EXPECT_NEAR(turned.x(), 0, 1e-6);
  EXPECT_NEAR(turned.y(), -quarter.x(), 1e-6);
}

/// Registrations of random pairs in all rotations: their errors are those that the covariances
/// state.
TEST(Registrar, CovarianceHoldsTheErrors) {
  constexpr int kPairs = 160;
  const cv::Size size(260, 240);
  Registrar registrar(size);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  double nees = 0;
  int within = 0;
  int found = 0;
  for (int i = 0; i < kPairs; ++i) {
    synthetic::CeilingParams params;
    params.seed = static_cast<std::uint32_t>(i);
    params.tile_px = 0;
    params.lamps = false;
    params.speckle_grey = i % 2 == 0 ? 14 : 7;
    const synthetic::SyntheticCeiling ceiling(params);
    const ImageMotion truth{
        50 * unit(random), 50 * unit(random), std::numbers::pi * unit(random), 1};
    const double noise = 1 + 3.0 * (i % 3);
    const auto seed = static_cast<std::uint32_t>(2 * i);
    const FrameSpectrum a = registrar.Analyze(ceiling.Render(size, {}, noise, seed));
    const FrameSpectrum b = registrar.Analyze(ceiling.Render(size, truth, noise, seed + 1));
    const Registration r = registrar.Register(a, b);
    if (!r.ok()) continue;
    const Eigen::Vector4d error(r.motion.tx_px - truth.tx_px,
                                r.motion.ty_px - truth.ty_px,
                                WrapAngle(r.motion.theta_rad - truth.theta_rad),
                                0);
    const double one = Nees(error, r.covariance, 3);
    nees += one;
    within += one < 7.815 / 3 ? 1 : 0;  // 95 % of chi squared, three degrees of freedom
    ++found;
  }
  ASSERT_GT(found, 0.8 * kPairs);
  EXPECT_GT(nees / found, 0.75);
  EXPECT_LT(nees / found, 1.3);
  EXPECT_GT(within, 0.9 * found);
}

}  // namespace
}  // namespace ceilmap::registration
