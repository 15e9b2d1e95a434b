#include "mapping/graph/selected_inverse.hpp"

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <utility>

#include "calib/base/error.hpp"

namespace ceilmap::graph {
namespace {

using Eigen::MatrixXd;

/// Columns with the same rows below them, which are eliminated together. The rows of a front are
/// its columns `first` ... `first + width - 1`, then `below`, all in order of elimination.
struct Front {
  int first = 0;
  int width = 0;
  int parent = -1;
  std::vector<int> below;
  std::vector<int> children;
  MatrixXd inverse;  // of the pivot F11
  MatrixXd ratio;    // F21 F11^-1

  [[nodiscard]] int Row(int i) const { return i < width ? first + i : below[i - width]; }
  [[nodiscard]] int Rows() const { return width + static_cast<int>(below.size()); }
};

/// Position of each row in the elimination order, which is chosen for little fill-in.
std::vector<int> EliminationOrder(int size, const std::vector<MatrixBlock>& blocks) {
  std::vector<Eigen::Triplet<int>> entries;
  for (const MatrixBlock& block : blocks) {
    entries.emplace_back(block.row, block.column, 1);
    entries.emplace_back(block.column, block.row, 1);
  }
  Eigen::SparseMatrix<int> pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  std::vector<int> position(size);
  for (int k = 0; k < size; ++k) position[order.indices()[k]] = k;
  return position;
}

/// The columns of the Cholesky factor: rows below the diagonal, sorted. A column passes its rows on
/// to its parent, which is the first of these rows.
std::vector<std::vector<int>> FactorColumns(int size, const std::vector<MatrixBlock>& blocks) {
  std::vector<std::vector<int>> rows(size);
  for (const MatrixBlock& block : blocks) {
    if (block.row != block.column) rows[block.column].push_back(block.row);
  }
  for (int k = 0; k < size; ++k) {
    std::vector<int>& column = rows[k];
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    if (column.empty()) continue;
    std::vector<int>& parent = rows[column.front()];
    parent.insert(parent.end(), column.begin() + 1, column.end());
  }
  return rows;
}

class Elimination {
 public:
  Elimination(int size, std::vector<MatrixBlock> blocks) : position_(size) {
    const std::vector<int> order = EliminationOrder(size, blocks);
    for (MatrixBlock& block : blocks) {
      block.row = order[block.row];
      block.column = order[block.column];
      if (block.row < block.column) {
        std::swap(block.row, block.column);
        block.value.transposeInPlace();
      }
    }
    MakeFronts(FactorColumns(size, blocks));
    Factorize(blocks);
    diagonal_.resize(size);
    Invert();
    std::vector<Eigen::Matrix3d> sorted(size);
    for (int i = 0; i < size; ++i) sorted[i] = diagonal_[order[i]];
    diagonal_ = std::move(sorted);
  }

  std::vector<Eigen::Matrix3d> Diagonal() && { return std::move(diagonal_); }

 private:
  void MakeFronts(std::vector<std::vector<int>> columns) {
    front_of_.resize(columns.size());
    for (int k = 0; k < static_cast<int>(columns.size()); ++k) {
      // A column is merged with the previous one when it is that one's parent and has no further
      // rows.
      const bool joins = k > 0 && !columns[k - 1].empty() && columns[k - 1].front() == k &&
                         columns[k - 1].size() == columns[k].size() + 1;
      if (!joins) {
        fronts_.emplace_back();
        fronts_.back().first = k;
      }
      ++fronts_.back().width;
      front_of_[k] = static_cast<int>(fronts_.size()) - 1;
    }
    for (int f = 0; f < static_cast<int>(fronts_.size()); ++f) {
      Front& front = fronts_[f];
      front.below = std::move(columns[front.first + front.width - 1]);
      if (front.below.empty()) continue;
      front.parent = front_of_[front.below.front()];
      fronts_[front.parent].children.push_back(f);
    }
  }

  /// Records the positions of the front's rows.
  void Locate(const Front& front) {
    for (int i = 0; i < front.Rows(); ++i) position_[front.Row(i)] = i;
  }

  /// F = sum of the matrix' own entries and the children's Schur complements; then the pivot is
  /// eliminated. Lower triangles only.
  void Factorize(std::vector<MatrixBlock>& blocks) {
    std::sort(blocks.begin(), blocks.end(), [](const MatrixBlock& a, const MatrixBlock& b) {
      return a.column < b.column;
    });
    std::vector<MatrixXd> left(fronts_.size());
    auto block = blocks.cbegin();
    for (std::size_t f = 0; f < fronts_.size(); ++f) {
      Front& front = fronts_[f];
      Locate(front);
      MatrixXd full = MatrixXd::Zero(3 * front.Rows(), 3 * front.Rows());
      for (; block != blocks.cend() && block->column < front.first + front.width; ++block) {
        full.block<3, 3>(3 * position_[block->row], 3 * position_[block->column]) += block->value;
      }
      for (const int child : front.children) {
        Add(fronts_[child].below, left[child], full);
        left[child] = MatrixXd();
      }
      left[f] = Eliminate(full, front);
    }
  }

  void Add(const std::vector<int>& rows, const MatrixXd& from, MatrixXd& to) const {
    for (std::size_t j = 0; j < rows.size(); ++j) {
      for (std::size_t i = j; i < rows.size(); ++i) {
        to.block<3, 3>(3 * position_[rows[i]], 3 * position_[rows[j]]) +=
            from.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j));
      }
    }
  }

  /// Returns the Schur complement F22 - F21 F11^-1 F12.
  static MatrixXd Eliminate(const MatrixXd& full, Front& front) {
    const Eigen::Index pivots = 3 * front.width;
    const Eigen::Index others = full.rows() - pivots;
    const Eigen::LLT<MatrixXd> llt(full.topLeftCorner(pivots, pivots));
    if (llt.info() != Eigen::Success) {
      throw RunError("the information of the pose graph is numerically singular");
    }
    front.inverse = llt.solve(MatrixXd::Identity(pivots, pivots));
    MatrixXd rest = full.bottomRightCorner(others, others);
    if (others == 0) return rest;
    MatrixXd half = full.bottomLeftCorner(others, pivots);  // F21 L^-T
    llt.matrixU().solveInPlace<Eigen::OnTheRight>(half);
    rest.selfadjointView<Eigen::Lower>().rankUpdate(half, -1);
    llt.matrixL().solveInPlace<Eigen::OnTheRight>(half);
    front.ratio = std::move(half);
    return rest;
  }

  /// Z21 = -Z22 F21 F11^-1 and Z11 = F11^-1 - (F21 F11^-1)' Z21, from the roots to the leaves. Z22
  /// is a part of the parent's Z, since all rows below a front are rows of its parent.
  void Invert() {
    std::vector<std::pair<int, MatrixXd>> open;
    for (int f = 0; f < static_cast<int>(fronts_.size()); ++f) {
      if (fronts_[f].parent < 0) open.emplace_back(f, MatrixXd());
    }
    while (!open.empty()) {
      const auto [f, below] = std::move(open.back());
      open.pop_back();
      const Front& front = fronts_[f];
      const Eigen::Index pivots = 3 * front.width;
      MatrixXd full(3 * front.Rows(), 3 * front.Rows());
      full.topLeftCorner(pivots, pivots) = front.inverse;
      if (below.rows() > 0) {
        const MatrixXd side = -below * front.ratio;
        full.topLeftCorner(pivots, pivots).noalias() -= front.ratio.transpose() * side;
        full.bottomLeftCorner(below.rows(), pivots) = side;
        full.topRightCorner(pivots, below.rows()) = side.transpose();
        full.bottomRightCorner(below.rows(), below.rows()) = below;
      }
      for (int i = 0; i < front.width; ++i) {
        const Eigen::Matrix3d z = full.block<3, 3>(3 * i, 3 * i);
        diagonal_[front.first + i] = (z + z.transpose()) / 2;
      }
      Locate(front);
      for (const int child : front.children) {
        open.emplace_back(child, Part(full, fronts_[child].below));
      }
    }
  }

  [[nodiscard]] MatrixXd Part(const MatrixXd& of, const std::vector<int>& rows) const {
    const auto size = static_cast<Eigen::Index>(rows.size());
    MatrixXd part(3 * size, 3 * size);
    for (Eigen::Index j = 0; j < size; ++j) {
      for (Eigen::Index i = 0; i < size; ++i) {
        part.block<3, 3>(3 * i, 3 * j) =
            of.block<3, 3>(3 * position_[rows[i]], 3 * position_[rows[j]]);
      }
    }
    return part;
  }

  std::vector<Front> fronts_;
  std::vector<int> front_of_;  // by column
  std::vector<int> position_;  // by row, valid for the rows of the front that was located last
  std::vector<Eigen::Matrix3d> diagonal_;
};

}  // namespace

std::vector<Eigen::Matrix3d> InverseDiagonal(int size, const std::vector<MatrixBlock>& blocks) {
  return Elimination(size, blocks).Diagonal();
}

}  // namespace ceilmap::graph
