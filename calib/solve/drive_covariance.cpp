#include "calib/solve/drive_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calib/base/sparse_cholesky.hpp"

namespace ceilmap::calibration {
namespace {

using Eigen::MatrixXd;

constexpr int kTimes = 8;  // parts of the drive with independent errors

// Raises variances to those of another estimate where that is larger.
void Raise(const MatrixXd& other, MatrixXd& covariance) {
  for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
    const double least = std::max(other(i, i), 1e-300);
    if (covariance(i, i) <= 0) {
      covariance.row(i).setZero();
      covariance.col(i).setZero();
      covariance(i, i) = least;
    } else if (covariance(i, i) < least) {
      const double factor = std::sqrt(least / covariance(i, i));
      covariance.row(i) *= factor;
      covariance.col(i) *= factor;
    }
  }
}

// The normal equations under the loss function, with the priors of the estimated errors.
SparseCholesky NormalWithPriors(const DriveProblem& problem, const Linearized& at) {
  const int n = at.jacobian.num_cols;
  std::vector<SparseCholesky::Entry> entries;
  const auto add_prior = [&](int k, double sigma) {
    entries.push_back({k, k, 1 / (sigma * sigma)});
  };
  for (int k = 0; k < n; ++k) entries.push_back({k, k, 1e-9});
  for (std::size_t k = 0; k < problem.estimated.size(); ++k) {
    add_prior(static_cast<int>(k), kPriorSigma[static_cast<std::size_t>(problem.estimated[k])]);
  }
  for (int k = 0; k < problem.heights; ++k) add_prior(n - 1 - k, kHeightSigma);
  std::size_t row = 0;
  for (const BlockOwner& owner : problem.owners) {
    const BlockTerm term = TermOf(owner, at, row, problem.problem);
    for (int k = 0; k < term.rows; ++k, ++row) {
      ForRow(at.jacobian, row, [&](int i, double by_i) {
        ForRow(at.jacobian, row, [&](int j, double by_j) {
          if (j <= i) entries.push_back({i, j, term.weight * by_i * by_j});
        });
      });
    }
  }
  return {n, entries};
}

}  // namespace

MatrixXd DriveCovariance(DriveProblem& problem, std::size_t views) {
  const Linearized at(problem);
  const auto asked = static_cast<Eigen::Index>(problem.estimated.size());
  const MatrixXd influence =
      NormalWithPriors(problem, at).Solve(MatrixXd::Identity(at.jacobian.num_cols, asked));
  MatrixXd of_view = MatrixXd::Zero(asked, static_cast<Eigen::Index>(views));
  MatrixXd of_time = MatrixXd::Zero(asked, kTimes);
  MatrixXd pairs = MatrixXd::Zero(asked, asked);
  for (const PairInfluence& pair : InfluenceOfPairs(problem, at, influence.transpose())) {
    of_view.col(pair.first) += pair.change;
    of_view.col(pair.second) += pair.change;
    of_time.col((pair.first + pair.second) * kTimes / (2 * static_cast<int>(views))) += pair.change;
    pairs += pair.change * pair.change.transpose();
  }
  MatrixXd covariance = of_view * of_view.transpose() - pairs;
  // Errors that belong to a part of the ceiling are common to all views of it.
  Raise(of_time * of_time.transpose() * (static_cast<double>(kTimes) / (kTimes - 1)), covariance);
  // Values that are not seen have the variance of the curvature.
  Raise(influence.topRows(asked), covariance);
  return covariance;
}

}  // namespace ceilmap::calibration
