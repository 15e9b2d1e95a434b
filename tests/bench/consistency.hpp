#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

/// Tables of errors compared with their covariances.
namespace ceilmap::bench {

/// Sums over the pairs of a cell, a row or a column of a table.
struct Consistency {
  int pairs = 0;
  int found = 0;
  int wrong = 0;  ///< so far off that no covariance describes it
  double nees = 0;
  int within = 0;               ///< the 95 % bound
  std::vector<double> parts{};  ///< NEES / dimension of some of the parameters
  double error2 = 0;

  void Add(const Consistency& other);
  [[nodiscard]] double Nees() const { return nees / std::max(1, found); }
  [[nodiscard]] double Share() const { return static_cast<double>(within) / std::max(1, found); }
};

/// Of one error. @param parts  Indices of parameters, whose NEES is summed apart.
Consistency ConsistencyOf(const Eigen::VectorXd& error,
                          const Eigen::MatrixXd& covariance,
                          const std::vector<std::vector<int>>& parts);

/// e' C^-1 e
double Mahalanobis2(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance);

/// Rows and columns of a table, and how a cell is filled.
struct ConsistencyTable {
  std::vector<std::string> scenes;
  std::vector<std::string> conditions;
  std::vector<std::string> parts;  ///< names of the columns of Consistency::parts
  std::string error;               ///< name of the column of Consistency::error2
  /// Conditions without a lower bound of their NEES.
  std::function<bool(const std::string& condition)> may_be_low;
};

/// Fills and prints a table. @param cell  The sum of one scene and condition, by their indices.
/// @return whether the mean of all is within 0.8 to 1.25, that of each scene and condition within
/// 0.5 to 2, and the share within 0.92 to 0.98
bool RunTable(const ConsistencyTable& table,
              const std::function<Consistency(std::size_t scene, std::size_t condition)>& cell);

/// Another seed for each pair of each cell: what its images show, their motion and noise are its
/// own.
std::uint32_t PairSeed(std::uint32_t seed,
                       const std::string& condition,
                       const std::string& scene,
                       int pair);

}  // namespace ceilmap::bench
