#include "mapping/registration/periods.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace ceilmap::registration {
namespace {

const cv::Size kLatticeSize(320, 240);

/// A lattice of narrow spots: the crossings of two waves, each seen along one basis vector.
cv::Mat Lattice(const Eigen::Matrix2d& basis) {
  const Eigen::Matrix2d to_cells = basis.inverse();
  cv::Mat image(kLatticeSize, CV_32FC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector2d cell = to_cells * Eigen::Vector2d(x, y);
      const Eigen::Vector2d wave = (2 * std::numbers::pi * cell).array().cos();
      image.at<float>(y, x) = static_cast<float>(20 * std::exp(4 * (wave.sum() - 2)) - 1);
    }
  }
  return image;
}

/// Distance of a shift from the lattice's nearest vector, pixels.
double OffLattice(const Eigen::Matrix2d& basis, const Eigen::Vector2d& shift) {
  const Eigen::Vector2d cells = (basis.inverse() * shift).array().round();
  return (shift - basis * cells).norm();
}

TEST(PeriodFinderTest, FindsTheVectorsOfALattice) {
  Eigen::Matrix2d upright;
  upright << 40, 0, 0, 30;
  Eigen::Matrix2d turned;  // by 30 degrees, not whole pixels
  turned << 38.4 * std::cos(0.5), -38.4 * std::sin(0.5), 38.4 * std::sin(0.5), 38.4 * std::cos(0.5);
  for (const Eigen::Matrix2d& basis : {upright, turned}) {
    const auto periods = PeriodFinder(kLatticeSize).Find(Lattice(basis));
    ASSERT_GE(periods.size(), 3U);
    double shortest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& period : periods) {
      EXPECT_LT(OffLattice(basis, period), 0.3) << period.transpose();
      shortest = std::min(shortest, period.norm());
    }
    EXPECT_NEAR(shortest, basis.col(1).norm(), 0.3);
  }
}

TEST(PeriodFinderTest, BlankPartsDoNotCount) {
  Eigen::Matrix2d basis;
  basis << 40, 0, 0, 30;
  cv::Mat image = Lattice(basis);
  image(cv::Rect(0, 0, 100, 240)).setTo(std::numeric_limits<float>::quiet_NaN());
  const auto periods = PeriodFinder(kLatticeSize).Find(image);
  ASSERT_FALSE(periods.empty());
  for (const Eigen::Vector2d& period : periods) EXPECT_LT(OffLattice(basis, period), 0.3);
}

TEST(PeriodFinderTest, NoiseHasNoPeriod) {
  cv::Mat noise(kLatticeSize, CV_32FC1);
  cv::RNG(5).fill(noise, cv::RNG::NORMAL, 0, 3);
  EXPECT_TRUE(PeriodFinder(kLatticeSize).Find(noise).empty());
  EXPECT_TRUE(PeriodFinder(kLatticeSize).Find(cv::Mat::zeros(kLatticeSize, CV_32FC1)).empty());
}

TEST(PeriodFinderTest, AGrilleIsNoGrid) {
  Eigen::Matrix2d grille;
  grille << 10, 0, 0, 12;
  for (const Eigen::Vector2d& period : PeriodFinder(kLatticeSize).Find(Lattice(grille))) {
    EXPECT_GT(period.norm(), 28);
  }
}

}  // namespace
}  // namespace ceilmap::registration
