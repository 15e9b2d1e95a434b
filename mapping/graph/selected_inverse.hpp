#pragma once

#include <Eigen/Core>
#include <vector>

namespace ceilmap::graph {

/// A block of a sparse symmetric matrix; blocks at the same position are summed.
struct MatrixBlock {
  int row = 0;
  int column = 0;  ///< <= row: only the lower triangle is given
  Eigen::Matrix3d value;
};

/// The diagonal blocks of the inverse of a sparse symmetric positive definite matrix of 3 x 3
/// blocks, without computing the full inverse: only its entries at the nonzeros of the Cholesky
/// factor are computed, from the last columns to the first (Takahashi, Fagan and Chen 1973; Erisman
/// and Tinney 1975), front by front along the elimination tree (Campbell and Davis 1995). The cost
/// is that of about three factorizations; the memory is that of the factor.
///
/// @param size  Number of block rows. Every diagonal block must be among `blocks`.
/// @throws RunError when the matrix is not numerically positive definite.
std::vector<Eigen::Matrix3d> InverseDiagonal(int size, const std::vector<MatrixBlock>& blocks);

}  // namespace ceilmap::graph
