#include "calib/base/sparse_cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <tuple>
#include <vector>

namespace ceilmap {
namespace {

TEST(SparseCholesky, SolvesAsADenseFactorization) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> element(0, 29);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(30, 30);
  std::vector<SparseCholesky::Entry> entries;
  for (int i = 0; i < 30; ++i) entries.push_back({i, i, 1});
  for (int k = 0; k < 60; ++k) {  // the normal equations of measured differences
    const int a = element(random);
    const int b = (a + 1 + element(random)) % 30;
    const double weight = std::exp(normal(random));
    for (const auto& [i, j, sign] : {std::tuple(a, a, 1), {b, b, 1}, {a, b, -1}, {b, a, -1}}) {
      dense(i, j) += sign * weight;
      if (i >= j) entries.push_back({i, j, sign * weight});
    }
  }
  const Eigen::MatrixXd b = Eigen::MatrixXd::NullaryExpr(30, 3, [&] { return normal(random); });
  const SparseCholesky solver(30, entries);
  ASSERT_TRUE(solver.HasFactors());
  EXPECT_LT((solver.Solve(b) - dense.llt().solve(b)).norm(), 1e-9);
}

TEST(SparseCholesky, EntriesAboveTheDiagonalDoNotCount) {
  const std::vector<SparseCholesky::Entry> entries = {{0, 0, 2}, {1, 1, 4}, {0, 1, 99}};
  const Eigen::VectorXd x = SparseCholesky(2, entries).Solve(Eigen::Vector2d(2, 4));
  EXPECT_NEAR(x[0], 1, 1e-15);
  EXPECT_NEAR(x[1], 1, 1e-15);
}

TEST(SparseCholesky, AMatrixThatIsNotDeterminedHasNoFactors) {
  const std::vector<SparseCholesky::Entry> difference = {{0, 0, 1}, {1, 0, -1}, {1, 1, 1}};
  EXPECT_FALSE(SparseCholesky(2, difference).HasFactors());
}

}  // namespace
}  // namespace ceilmap
