#include "mapping/registration/motion_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace ceilmap::registration {
namespace {

using Parameters = Eigen::Vector4d;  // tx, ty, theta, ln scale

Eigen::Vector2d LinearShift(const Eigen::Vector2d& p, const Parameters& motion) {
  return {motion[0] - motion[2] * p.y() + motion[3] * p.x(),
          motion[1] + motion[2] * p.x() + motion[3] * p.y()};
}

/// 8 x 6 blocks over an image of 640x480.
std::vector<BlockShift> Grid(const Parameters& motion) {
  std::vector<BlockShift> blocks;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 8; ++i) {
      BlockShift block;
      block.point = {72.0 * i - 252, 72.0 * j - 180};
      block.shift = LinearShift(block.point, motion);
      block.peak = 0.8;
      blocks.push_back(block);
    }
  }
  return blocks;
}

Parameters ParametersOf(const MotionFit& fit) {
  return {fit.motion.tx_px, fit.motion.ty_px, fit.motion.theta_rad, std::log(fit.motion.scale)};
}

/// Largest difference, the angle and the scale as shifts at 250 px from the centre.
double Error(const MotionFit& fit, const Parameters& truth) {
  return (ParametersOf(fit) - truth).cwiseProduct(Parameters(1, 1, 250, 250)).cwiseAbs().maxCoeff();
}

const Parameters kRigid(0.6, -1.1, 0.004, 0);
const Parameters kSimilarity(-0.8, 0.3, -0.003, 0.005);

FitParams ScaleParams(bool scale) {
  FitParams params;
  params.estimate_scale = scale;
  return params;
}

TEST(FitRobust, ExactMotions) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 50; ++i) {
    const bool scale = i % 2 == 0;
    const Parameters truth(
        3 * unit(random), 3 * unit(random), 0.02 * unit(random), scale ? 0.02 * unit(random) : 0);
    const MotionFit fit = FitRobust(Grid(truth), ScaleParams(scale));
    ASSERT_TRUE(fit.ok);
    EXPECT_LT(Error(fit, truth), 1e-9);
    EXPECT_EQ(fit.inliers, 48);
    EXPECT_EQ(fit.weights.size(), 48U);
    EXPECT_EQ(fit.sigma_px, kSigmaFloorPx);
  }
}

TEST(FitRobust, HoldsAFixedScale) {
  const MotionFit fit = FitRobust(Grid(kSimilarity), ScaleParams(false));
  ASSERT_TRUE(fit.ok);
  EXPECT_EQ(fit.motion.scale, 1);
  EXPECT_EQ(fit.covariance.row(3).norm(), 0);
  EXPECT_EQ(fit.covariance.col(3).norm(), 0);
  EXPECT_NEAR(fit.motion.theta_rad, kSimilarity[2], 1e-9) << "the grid is symmetric";
}

bool IsOutlier(std::size_t block) {
  return (7 * block) % 5 < 2;
}
constexpr int kOutliers = 19;  // of 48

/// Two of five blocks contradict, by at least 3 px.
std::vector<BlockShift> WithOutliers(const Parameters& truth, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> radius(3, 9);
  std::uniform_real_distribution<double> angle(0, 6.283);
  std::vector<BlockShift> blocks = Grid(truth);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!IsOutlier(i)) continue;
    const double r = radius(random);
    const double a = angle(random);
    blocks[i].shift += Eigen::Vector2d(r * std::cos(a), r * std::sin(a));
  }
  return blocks;
}

TEST(FindConsensus, FortyPercentOutliers) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    for (const Parameters& truth : {kRigid, kSimilarity}) {
      const FitParams params = ScaleParams(truth[3] != 0);
      const auto blocks = WithOutliers(truth, seed);
      const MotionFit consensus = FindConsensus(blocks, params);
      ASSERT_TRUE(consensus.ok);
      EXPECT_LT(Error(consensus, truth), 1e-9);
      EXPECT_EQ(consensus.inliers, 48 - kOutliers);
      const MotionFit fit = FitRobust(blocks, params, consensus.weights);
      ASSERT_TRUE(fit.ok);
      EXPECT_LT(Error(fit, truth), 1e-9);
      EXPECT_EQ(fit.inliers, 48 - kOutliers);
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        EXPECT_EQ(fit.weights[i] > 0, !IsOutlier(i)) << i;
      }
    }
  }
}

TEST(FitRobust, FewOutliersNeedNoStart) {
  auto blocks = Grid(kRigid);
  for (std::size_t i = 0; i < blocks.size(); i += 6) blocks[i].shift += Eigen::Vector2d(-4, 3);
  const MotionFit fit = FitRobust(blocks, ScaleParams(false));
  ASSERT_TRUE(fit.ok);
  EXPECT_LT(Error(fit, kRigid), 1e-6);
}

/// Compares the reported covariance with the spread of the results over many draws of the noise.
void CheckCovariance(const Parameters& truth, bool varied_quality) {
  constexpr int kDraws = 1500;
  constexpr double kSigma = 0.06;
  const bool scale = truth[3] != 0;
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, kSigma);
  Parameters squares = Parameters::Zero();
  Parameters reported = Parameters::Zero();
  for (int draw = 0; draw < kDraws; ++draw) {
    auto blocks = Grid(truth);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      blocks[i].quality = varied_quality ? 0.5 + static_cast<double>(i % 5) : 1.0;
      blocks[i].shift +=
          Eigen::Vector2d(normal(random), normal(random)) / std::sqrt(blocks[i].quality);
    }
    const MotionFit fit = FitRobust(blocks, ScaleParams(scale));
    ASSERT_TRUE(fit.ok);
    squares += (ParametersOf(fit) - truth).cwiseAbs2() / kDraws;
    reported += fit.covariance.diagonal() / kDraws;
  }
  for (int i = 0; i < (scale ? 4 : 3); ++i) {
    EXPECT_NEAR(reported[i] / squares[i], 1, 0.25) << "parameter " << i;
  }
}

TEST(FitRobust, CovarianceIsTheSpreadOfTheResults) {
  CheckCovariance(kRigid, false);
}
TEST(FitRobust, CovarianceWithScale) {
  CheckCovariance(kSimilarity, false);
}
TEST(FitRobust, CovarianceOfBlocksOfDifferentQuality) {
  CheckCovariance(kRigid, true);
}

TEST(FitRobust, BlocksOnEdgesCountAcrossTheEdge) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> along_the_edge(-4, 4);
  auto blocks = Grid(kRigid);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const bool sees_x = i % 2 == 0;
    blocks[i].sharpness = Eigen::Vector2d(sees_x ? 1 : 0, sees_x ? 0 : 1).asDiagonal();
    (sees_x ? blocks[i].shift.y() : blocks[i].shift.x()) += along_the_edge(random);
  }
  const MotionFit consensus = FindConsensus(blocks, ScaleParams(false));
  ASSERT_TRUE(consensus.ok);
  EXPECT_EQ(consensus.inliers, 48);
  const MotionFit fit = FitRobust(blocks, ScaleParams(false), consensus.weights);
  ASSERT_TRUE(fit.ok);
  EXPECT_LT(Error(fit, kRigid), 1e-9);
}

TEST(FitRobust, ParallelEdgesAloneDetermineNothing) {
  auto blocks = Grid(kRigid);
  for (BlockShift& block : blocks) block.sharpness = Eigen::Vector2d(1, 0).asDiagonal();
  EXPECT_FALSE(FitRobust(blocks, ScaleParams(false)).ok);
}

TEST(FitRobust, TooFewOrOneSpotIsNotOk) {
  for (const std::size_t n : {0U, 1U, 2U}) {
    auto blocks = Grid(kRigid);
    blocks.resize(n);
    EXPECT_FALSE(FitRobust(blocks, ScaleParams(false)).ok) << n;
    EXPECT_FALSE(FindConsensus(blocks, ScaleParams(false)).ok) << n;
  }
  const std::vector<BlockShift> same(10, Grid(kRigid).front());
  EXPECT_FALSE(FitRobust(same, ScaleParams(false)).ok);
  EXPECT_FALSE(FindConsensus(same, ScaleParams(false)).ok);
}

TEST(FitRobust, WorthlessBlocksAreNotOk) {
  auto blocks = Grid(kRigid);
  for (BlockShift& block : blocks) {
    block.quality = 0;
    block.sharpness.setZero();
  }
  const MotionFit fit = FitRobust(blocks, ScaleParams(true));
  EXPECT_FALSE(fit.ok);
  EXPECT_TRUE(fit.covariance.allFinite());
}

TEST(FindConsensus, ChanceIsNoConsensus) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(-8, 8);
  auto blocks = Grid(kRigid);
  for (BlockShift& block : blocks) block.shift = {any(random), any(random)};
  EXPECT_LT(FindConsensus(blocks, ScaleParams(false)).inliers, 14);
}

}  // namespace
}  // namespace ceilmap::registration
