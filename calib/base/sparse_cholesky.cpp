#include "calib/base/sparse_cholesky.hpp"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <vector>

namespace ceilmap {

struct SparseCholesky::Factors : Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> {
  using SimplicialLDLT::SimplicialLDLT;
};

SparseCholesky::SparseCholesky(Eigen::Index size, std::span<const Entry> entries) {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(entries.size());
  for (const Entry& entry : entries) {
    if (entry.row >= entry.column) triplets.emplace_back(entry.row, entry.column, entry.value);
  }
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  factors_ = std::make_unique<Factors>(matrix);
}

SparseCholesky::~SparseCholesky() = default;

bool SparseCholesky::HasFactors() const {
  return factors_->info() == Eigen::Success;
}

Eigen::MatrixXd SparseCholesky::Solve(const Eigen::Ref<const Eigen::MatrixXd>& b) const {
  return factors_->solve(b);
}

}  // namespace ceilmap
