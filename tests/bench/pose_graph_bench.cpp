// Pose graphs of known worlds, from g2o text: OptimizePoses against Ceres' usual formulation of the
// same problem, from the same start, interleaved in one run. Prints a table; exits with 1 when the
// two do not reach the same cost.

#include <ceres/ceres.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "mapping/graph/pose_graph.hpp"
#include "tests/bench/median.hpp"
#include "tests/mapping/graph/synthetic_graph.hpp"

namespace ceilmap::mapping {
namespace {

using bench::Median;

constexpr double kMaxCostDifference = 1e-6;

double Seconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

/// What one of the two made of a graph.
struct Outcome {
  std::vector<Pose2> poses;
  int iterations = 0;
  double cost = 0;  ///< as reported
  std::vector<double> seconds;
};

// --- The usual formulation: x, y and yaw are parameters of their own, yaw on a manifold, and
// derivatives are automatic.

template <typename T>
T Normalized(const T& angle) {
  const T turn(2 * std::numbers::pi);
  return angle - turn * ceres::floor((angle + T(std::numbers::pi)) / turn);
}

struct AngleManifold {
  template <typename T>
  bool Plus(const T* angle, const T* delta, T* sum) const {
    *sum = Normalized(*angle + *delta);
    return true;
  }
  template <typename T>
  bool Minus(const T* a, const T* b, T* difference) const {
    *difference = Normalized(*a - *b);
    return true;
  }
};

struct AutoDiffError {
  Pose2 T_from_to;
  Eigen::Matrix3d whitening;

  template <typename T>
  bool operator()(const T* from_x,
                  const T* from_y,
                  const T* from_yaw,
                  const T* to_x,
                  const T* to_y,
                  const T* to_yaw,
                  T* residual) const {
    Eigen::Matrix<T, 2, 2> R_map_from;
    R_map_from << ceres::cos(*from_yaw), -ceres::sin(*from_yaw), ceres::sin(*from_yaw),
        ceres::cos(*from_yaw);
    const Eigen::Matrix<T, 2, 1> step(*to_x - *from_x, *to_y - *from_y);
    Eigen::Matrix<T, 3, 1> error;
    error.template head<2>() =
        R_map_from.transpose() * step - T_from_to.Translation().template cast<T>();
    error[2] = Normalized(*to_yaw - *from_yaw - T(T_from_to.yaw));
    Eigen::Map<Eigen::Matrix<T, 3, 1>>{residual} = whitening.template cast<T>() * error;
    return true;
  }
};

void SolvePlain(const graph::synthetic::PoseGraph& graph, Outcome& outcome) {
  outcome.poses = graph.poses;
  const double start = Seconds();
  ceres::Problem problem;
  auto* manifold = new ceres::AutoDiffManifold<AngleManifold, 1, 1>;
  for (const graph::Edge& edge : graph.edges) {
    Pose2& from = outcome.poses[edge.from];
    Pose2& to = outcome.poses[edge.to];
    const Eigen::Matrix3d whitening = edge.information.llt().matrixU();
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<AutoDiffError, 3, 1, 1, 1, 1, 1, 1>(
                                 new AutoDiffError{edge.T_from_to, whitening}),
                             nullptr,
                             &from.x,
                             &from.y,
                             &from.yaw,
                             &to.x,
                             &to.y,
                             &to.yaw);
    problem.SetManifold(&from.yaw, manifold);
    problem.SetManifold(&to.yaw, manifold);
  }
  for (const std::int64_t id : graph.fixed) {
    Pose2& pose = outcome.poses[id];
    for (double* parameter : {&pose.x, &pose.y, &pose.yaw}) {
      problem.SetParameterBlockConstant(parameter);
    }
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 100;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  outcome.seconds.push_back(Seconds() - start);
  outcome.iterations = static_cast<int>(summary.iterations.size()) - 1;
  outcome.cost = summary.final_cost;
}

// --- Ours.

void SolveOurs(const graph::synthetic::PoseGraph& graph,
               const graph::PoseGraphParams& params,
               Outcome& outcome) {
  outcome.poses = graph.poses;
  const double start = Seconds();
  const graph::PoseGraphSummary summary =
      graph::OptimizePoses(graph.edges, graph.fixed, outcome.poses, params);
  outcome.seconds.push_back(Seconds() - start);
  outcome.iterations = summary.iterations;
  outcome.cost = summary.final_cost;
}

/// Half the sum of squares at the poses, computed equally for both.
double Cost(const graph::synthetic::PoseGraph& graph, const std::vector<Pose2>& poses) {
  double sum = 0;
  for (const graph::Edge& edge : graph.edges) {
    sum += graph::EdgeChi2(edge, poses[edge.from], poses[edge.to]) / 2;
  }
  return sum;
}

double LargestDistance(const std::vector<Pose2>& a, const std::vector<Pose2>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, (a[i].Translation() - b[i].Translation()).norm());
  }
  return largest;
}

void PrintRow(const char* name, const graph::synthetic::PoseGraph& graph, const Outcome& outcome) {
  fmt::print("  {:<24}{:>12}{:>18.8f}{:>12.1f}{:>12.1f}\n",
             name,
             outcome.iterations,
             Cost(graph, outcome.poses),
             1e3 * Median(outcome.seconds),
             1e3 * *std::min_element(outcome.seconds.begin(), outcome.seconds.end()));
}

/// Whether both reached the same cost, by their own account and by a common one.
bool Compare(const std::string& name, const graph::synthetic::World& world, int repetitions) {
  const graph::synthetic::PoseGraph& graph = world.graph;
  const graph::PoseGraphParams plain_squares = {.loop_loss_scale = 0};
  Outcome plain;
  Outcome ours;
  Outcome robust;
  std::vector<double> covariance_seconds;
  for (int i = 0; i < repetitions; ++i) {
    SolvePlain(graph, plain);
    SolveOurs(graph, plain_squares, ours);
    SolveOurs(graph, {}, robust);
    const double start = Seconds();
    graph::MarginalCovariances(graph.edges, graph.fixed, ours.poses, plain_squares);
    covariance_seconds.push_back(Seconds() - start);
  }
  fmt::print("{}: {} poses, {} edges, start {:.2f} m off, start cost {:.1f}, {} repetitions\n",
             name,
             graph.poses.size(),
             graph.edges.size(),
             LargestDistance(graph.poses, world.truth),
             Cost(graph, graph.poses),
             repetitions);
  fmt::print(
      "  {:<24}{:>12}{:>18}{:>12}{:>12}\n", "", "iterations", "cost", "median ms", "best ms");
  PrintRow("Ceres, usual form", graph, plain);
  PrintRow("OptimizePoses", graph, ours);
  PrintRow("  with robust loss", graph, robust);
  fmt::print("  {:<24}{:>54.1f}\n", "MarginalCovariances", 1e3 * Median(covariance_seconds));
  const double own = std::abs(ours.cost - plain.cost) / plain.cost;
  const double common =
      std::abs(Cost(graph, ours.poses) - Cost(graph, plain.poses)) / Cost(graph, plain.poses);
  fmt::print("  cost differs by {:.1e}, poses by {:.1e} m; time ratio Ceres / ours {:.2f}\n\n",
             std::max(own, common),
             LargestDistance(ours.poses, plain.poses),
             Median(plain.seconds) / Median(ours.seconds));
  return std::max(own, common) <= kMaxCostDifference;
}

/// Peak memory of a process that makes a graph and optimizes it, MB.
double PeakMegabytes(int side, const std::function<void(graph::synthetic::PoseGraph&)>& solve) {
  const pid_t child = fork();
  if (child == 0) {
    graph::synthetic::World world = graph::synthetic::Lawnmower(side, side, 1);
    solve(world.graph);
    _exit(0);
  }
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  constexpr double kKilobytes = 1024;
  return static_cast<double>(usage.ru_maxrss) / kKilobytes;
}

void PrintMemory(int side) {
  const auto ceres = [](const graph::synthetic::PoseGraph& graph) {
    Outcome outcome;
    SolvePlain(graph, outcome);
  };
  const auto ours = [](const graph::synthetic::PoseGraph& graph) {
    Outcome outcome;
    SolveOurs(graph, {.loop_loss_scale = 0}, outcome);
  };
  const auto whole = [](graph::synthetic::PoseGraph& graph) {
    graph::MarginalCovariances(graph.edges, graph.fixed, graph.poses);
  };
  const double empty = PeakMegabytes(side, [](graph::synthetic::PoseGraph&) {});
  fmt::print(
      "{} poses: peak memory beyond {:.0f} MB of the process and its graph\n", side * side, empty);
  fmt::print("  Ceres, usual form     {:>6.0f} MB\n", PeakMegabytes(side, ceres) - empty);
  fmt::print("  OptimizePoses         {:>6.0f} MB\n", PeakMegabytes(side, ours) - empty);
  fmt::print("  MarginalCovariances   {:>6.0f} MB\n\n", PeakMegabytes(side, whole) - empty);
  std::fflush(stdout);
}

int Main(int repetitions, int side) {
  PrintMemory(side);
  const bool manhattan = Compare("manhattan", graph::synthetic::Manhattan(3500, 1), repetitions);
  const bool lawnmower =
      Compare("lawnmower", graph::synthetic::Lawnmower(side, side, 1), repetitions);
  if (manhattan && lawnmower) return 0;
  fmt::print("the costs differ by more than {:.0e}\n", kMaxCostDifference);
  return 1;
}

}  // namespace
}  // namespace ceilmap::mapping

/// Usage: ceilmap_pose_graph_bench [REPETITIONS [SIDE]]
/// SIDE: of the second graph, 100 for 10,000 poses; 200 for the map of a building.
int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::max(1, std::atoi(argv[1])) : 7;
  const int side = argc > 2 ? std::clamp(std::atoi(argv[2]), 2, 2000) : 100;
  return ceilmap::mapping::Main(repetitions, side);
}
