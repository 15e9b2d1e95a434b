#include "calib/solve/pair_problem.hpp"

#include <utility>

namespace ceilmap::calibration {

bool Minimise(PairProblem& problem, int max_iterations) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = max_iterations;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem.problem, &summary);
  return summary.IsSolutionUsable();
}

Linearized::Linearized(PairProblem& problem) {
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  options.parameter_blocks = problem.blocks;
  options.residual_blocks.reserve(problem.owners.size());
  for (const BlockOwner& owner : problem.owners) options.residual_blocks.push_back(owner.id);
  problem.problem.Evaluate(options, nullptr, &residuals, nullptr, &jacobian);
}

BlockTerm TermOf(const BlockOwner& owner,
                 const Linearized& at,
                 std::size_t row,
                 const ceres::Problem& problem) {
  BlockTerm term;
  term.rows = problem.GetCostFunctionForResidualBlock(owner.id)->num_residuals();
  if (!owner.place) return term;
  double square = 0;
  for (int k = 0; k < term.rows; ++k) {
    const double r = at.residuals[row + static_cast<std::size_t>(k)];
    square += r * r;
  }
  term.weight = 1 / (1 + square / (kCauchy * kCauchy));
  term.bend = -2 * term.weight * term.weight / (kCauchy * kCauchy);
  return term;
}

void AddOuter(const ceres::CRSMatrix& m, std::size_t row, double weight, Eigen::MatrixXd& H) {
  ForRow(m, row, [&](int i, double a) {
    ForRow(m, row, [&](int j, double b) { H(i, j) += weight * a * b; });
  });
}

std::vector<PairInfluence> InfluenceOfPairs(const PairProblem& problem,
                                            const Linearized& at,
                                            const Eigen::MatrixXd& influence) {
  std::vector<PairInfluence> pairs;
  Eigen::VectorXd change = Eigen::VectorXd::Zero(influence.rows());
  std::size_t row = 0;
  for (std::size_t i = 0; i < problem.owners.size(); ++i) {
    const BlockOwner& owner = problem.owners[i];
    const BlockTerm term = TermOf(owner, at, row, problem.problem);
    for (int k = 0; k < term.rows; ++k, ++row) {
      const double pull = term.weight * at.residuals[row];
      ForRow(at.jacobian, row, [&](int column, double a) {
        change += pull * a * influence.col(column);
      });
    }
    const bool last = i + 1 == problem.owners.size() ||
                      problem.owners[i + 1].first != owner.first ||
                      problem.owners[i + 1].second != owner.second;
    if (!last) continue;
    pairs.push_back({owner.first, owner.second, change});
    change.setZero();
  }
  return pairs;
}

}  // namespace ceilmap::calibration
