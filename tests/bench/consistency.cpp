#include "tests/bench/consistency.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace ceilmap::bench {
namespace {

void PrintHeader(const ConsistencyTable& table) {
  fmt::print("{:<16}{:<18}{:>6}{:>7}{:>7}{:>8}{:>8}",
             "scene",
             "condition",
             "pairs",
             "found",
             "wrong",
             "NEES/n",
             "in 95%");
  for (const std::string& part : table.parts) fmt::print("{:>8}", part);
  fmt::print("{:>11}\n", table.error);
}

void PrintRow(const std::string& scene, const std::string& condition, const Consistency& sum) {
  const double n = std::max(1, sum.found);
  fmt::print("{:<16}{:<18}{:>6}{:>7}{:>7}{:>8.2f}{:>8.3f}",
             scene,
             condition,
             sum.pairs,
             sum.found,
             sum.wrong,
             sum.Nees(),
             sum.Share());
  for (const double part : sum.parts) fmt::print("{:>8.2f}", part / n);
  fmt::print("{:>11.4f}\n", std::sqrt(sum.error2 / n));
  std::fflush(stdout);
}

}  // namespace

void Consistency::Add(const Consistency& other) {
  pairs += other.pairs;
  found += other.found;
  wrong += other.wrong;
  nees += other.nees;
  within += other.within;
  error2 += other.error2;
  parts.resize(std::max(parts.size(), other.parts.size()), 0);
  for (std::size_t i = 0; i < other.parts.size(); ++i) parts[i] += other.parts[i];
}

double Mahalanobis2(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  // Pixels and radians: scaled, so that the pivots can be compared.
  const Eigen::VectorXd d = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd e = d.asDiagonal() * error;
  return e.dot((d.asDiagonal() * covariance * d.asDiagonal()).eval().ldlt().solve(e));
}

Consistency ConsistencyOf(const Eigen::VectorXd& error,
                          const Eigen::MatrixXd& covariance,
                          const std::vector<std::vector<int>>& parts) {
  // 95 % of chi squared by degrees of freedom.
  constexpr std::array<double, 7> kBounds{0, 3.841, 5.991, 7.815, 9.488, 11.070, 12.592};
  const auto n = static_cast<std::size_t>(error.size());
  Consistency one;
  one.pairs = 1;
  one.found = 1;
  const double nees = Mahalanobis2(error, covariance);
  one.nees = nees / static_cast<double>(n);
  one.within = nees < kBounds.at(n) ? 1 : 0;
  for (const std::vector<int>& part : parts) {
    one.parts.push_back(Mahalanobis2(error(part), covariance(part, part)) /
                        static_cast<double>(part.size()));
  }
  return one;
}

bool RunTable(const ConsistencyTable& table,
              const std::function<Consistency(std::size_t, std::size_t)>& cell) {
  std::vector<Consistency> by_scene(table.scenes.size());
  std::vector<Consistency> by_condition(table.conditions.size());
  Consistency all;
  PrintHeader(table);
  for (std::size_t c = 0; c < table.conditions.size(); ++c) {
    for (std::size_t s = 0; s < table.scenes.size(); ++s) {
      const Consistency sum = cell(s, c);
      PrintRow(table.scenes[s], table.conditions[c], sum);
      by_scene[s].Add(sum);
      by_condition[c].Add(sum);
      all.Add(sum);
    }
  }
  fmt::print("\n");
  PrintHeader(table);
  bool bounded = all.Nees() > 0.8 && all.Nees() < 1.25 && all.Share() > 0.92 && all.Share() < 0.98;
  for (std::size_t s = 0; s < by_scene.size(); ++s) {
    PrintRow(table.scenes[s], "all", by_scene[s]);
    bounded = bounded && by_scene[s].Nees() > 0.5 && by_scene[s].Nees() < 2;
  }
  for (std::size_t c = 0; c < by_condition.size(); ++c) {
    PrintRow("all", table.conditions[c], by_condition[c]);
    bounded = bounded && by_condition[c].Nees() < 2 &&
              (by_condition[c].Nees() > 0.5 || table.may_be_low(table.conditions[c]));
  }
  PrintRow("all", "all", all);
  return bounded;
}

std::uint32_t PairSeed(std::uint32_t seed,
                       const std::string& condition,
                       const std::string& scene,
                       int pair) {
  const std::string text = fmt::format("{}|{}|{}|{}", seed, condition, scene, pair);
  std::uint32_t hash = 2166136261U;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

}  // namespace ceilmap::bench
