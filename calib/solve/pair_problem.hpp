#pragma once

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

/// What the fits of rig_solver.hpp and drive_solver.hpp have in common: residuals of points that
/// two views show, under Cauchy's loss, and what each pair of views contributes to the covariance.
/// Points of one pair share the errors of its two images; their residuals are not independent.
/// Internal to both solvers.
namespace ceilmap::calibration {

/// Cauchy's parameter in standard deviations: keeps 95 % of the efficiency.
inline constexpr double kCauchy = 2.3849;

/// Views of a residual block.
struct BlockOwner {
  ceres::ResidualBlockId id = nullptr;
  int first = -1;   ///< index of the view
  int second = -1;  ///< -1: of one view only
  bool place = false;
};

/// A least-squares problem whose residuals all have standard deviation 1.
struct PairProblem {
  ceres::Problem problem;
  std::vector<BlockOwner> owners;  ///< of the residual blocks, those of one pair together
  std::vector<double*> blocks;     ///< free parameters, in the order of the Jacobian's columns
};

/// Solves a problem from the values of its parameters, which change.
/// @return false where there is no usable solution.
bool Minimise(PairProblem& problem, int max_iterations);

/// Residuals of all owners' blocks, and their Jacobian by the free parameters, row by row, without
/// the loss function.
struct Linearized {
  explicit Linearized(PairProblem& problem);
  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;
};

/// Contribution of one residual block to the normal equations under the loss rho(s).
struct BlockTerm {
  int rows = 0;
  double weight = 1;  ///< rho'
  double bend = 0;    ///< 2 rho''
};
/// @param row  first row of the block.
BlockTerm TermOf(const BlockOwner& owner,
                 const Linearized& at,
                 std::size_t row,
                 const ceres::Problem& problem);

/// Writes weight * derivative as a block of a cost function's Jacobian. A block that Ceres holds
/// constant is null.
template <int kCols>
void WriteJacobian(const Eigen::Matrix2d& weight,
                   const Eigen::Matrix<double, 2, kCols>& derivative,
                   double* jacobian) {
  if (jacobian == nullptr) return;
  constexpr int kOrder = kCols == 1 ? Eigen::ColMajor : Eigen::RowMajor;
  Eigen::Map<Eigen::Matrix<double, 2, kCols, kOrder>>(jacobian).noalias() = weight * derivative;
}

/// Calls use(column, value) for each value of a row of the Jacobian.
template <typename Use>
void ForRow(const ceres::CRSMatrix& m, std::size_t row, const Use& use) {
  for (int k = m.rows[row]; k < m.rows[row + 1]; ++k) {
    use(m.cols[static_cast<std::size_t>(k)], m.values[static_cast<std::size_t>(k)]);
  }
}

/// H += weight * a' a, where a is a row of the Jacobian.
void AddOuter(const ceres::CRSMatrix& m, std::size_t row, double weight, Eigen::MatrixXd& H);

/// Change of some quantities by the residuals of one pair of views.
struct PairInfluence {
  int first = -1;
  int second = -1;  ///< -1: residuals of one view only
  Eigen::VectorXd change;
};
/// @param influence  Of each free parameter's gradient (columns) on each quantity (rows).
std::vector<PairInfluence> InfluenceOfPairs(const PairProblem& problem,
                                            const Linearized& at,
                                            const Eigen::MatrixXd& influence);

}  // namespace ceilmap::calibration
