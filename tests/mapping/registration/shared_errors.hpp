#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <random>
#include <vector>

#include "mapping/registration/motion_covariance.hpp"
#include "mapping/registration/poc.hpp"

namespace ceilmap::registration {

inline SharedNoise SharedByBlocks(int block_px, double px_per_sample = 1) {
  return SharedNoise(TukeyWindow(block_px, PocParams{}.taper), px_per_sample);
}

/// Random errors of blocks, correlated by what they share.
class SharedErrors {
 public:
  SharedErrors(const std::vector<Eigen::Vector2d>& points, const SharedNoise& shared) {
    const auto n = static_cast<Eigen::Index>(points.size());
    Eigen::MatrixXd correlation(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index k = 0; k < n; ++k) {
        correlation(i, k) = shared.Correlation(points[static_cast<std::size_t>(i)] -
                                               points[static_cast<std::size_t>(k)]);
      }
    }
    root_ = correlation.llt().matrixL();
  }

  /// One row for each block, unit variance.
  [[nodiscard]] Eigen::MatrixXd Draw(std::mt19937& random) const {
    std::normal_distribution<double> normal;
    Eigen::MatrixXd errors(root_.rows(), 2);
    for (double& value : errors.reshaped()) value = normal(random);
    return root_ * errors;
  }

 private:
  Eigen::MatrixXd root_;
};

/// Error relative to the covariance, squared, for each dimension; 1 in the mean when they agree.
inline double NeesOf(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd d = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd e = d.asDiagonal() * error;
  return e.dot((d.asDiagonal() * covariance * d.asDiagonal()).eval().ldlt().solve(e)) /
         static_cast<double>(error.size());
}

}  // namespace ceilmap::registration
