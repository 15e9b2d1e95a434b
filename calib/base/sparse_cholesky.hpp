#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>

namespace ceilmap {

/// Factors of a large, sparse, symmetric, positive definite matrix, as normal equations are.
/// One place for all of them: each use of Eigen's own class takes seconds to compile.
class SparseCholesky {
 public:
  /// A summand of one element of the matrix.
  struct Entry {
    int row;
    int column;
    double value;
  };

  /// Factors the matrix of size x size elements. Cost: as Eigen::SimplicialLDLT, with columns in
  /// the order that approximately fills least.
  /// @param entries  on the diagonal and below; those above it are not looked at. Entries of one
  ///                 element are added.
  SparseCholesky(Eigen::Index size, std::span<const Entry> entries);
  ~SparseCholesky();

  /// Whether the matrix has factors: no pivot was zero.
  [[nodiscard]] bool HasFactors() const;

  /// The solution x of the matrix times x = b, column by column. Needs factors.
  [[nodiscard]] Eigen::MatrixXd Solve(const Eigen::Ref<const Eigen::MatrixXd>& b) const;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

}  // namespace ceilmap
