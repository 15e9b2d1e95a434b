#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"

/// Pose graphs whose truth is known.
namespace ceilmap::graph::synthetic {

/// Standard deviations of a measured motion.
struct MotionNoise {
  double xy = 0;   ///< m
  double yaw = 0;  ///< rad
};

struct PoseGraph {
  std::vector<Pose2> poses;  ///< T_map_base by keyframe id
  std::vector<Edge> edges;
  std::vector<std::int64_t> fixed;
};

struct World {
  std::vector<Pose2> truth;
  PoseGraph graph;  ///< poses by dead reckoning along the odometry; the first is fixed
};

inline Edge MeasuredEdge(std::int64_t from,
                         std::int64_t to,
                         const std::vector<Pose2>& truth,
                         const MotionNoise& noise,
                         std::mt19937& random) {
  std::normal_distribution<double> normal;
  Edge edge;
  edge.from = from;
  edge.to = to;
  edge.kind = to == from + 1 ? Edge::Kind::kOdometry : Edge::Kind::kLoopClosure;
  const Pose2 T_from_to = truth[from].Inverse() * truth[to];
  edge.T_from_to = {T_from_to.x + noise.xy * normal(random),
                    T_from_to.y + noise.xy * normal(random),
                    WrapAngle(T_from_to.yaw + noise.yaw * normal(random))};
  const Eigen::Vector3d sigma(noise.xy, noise.xy, noise.yaw);
  edge.information = sigma.cwiseAbs2().cwiseInverse().asDiagonal();
  return edge;
}

/// Odometry along the truth, and the poses that it leads to.
inline World Drive(std::vector<Pose2> truth, const MotionNoise& noise, std::mt19937& random) {
  World world;
  world.graph.poses = {truth.front()};
  for (std::size_t i = 1; i < truth.size(); ++i) {
    const auto to = static_cast<std::int64_t>(i);
    world.graph.edges.push_back(MeasuredEdge(to - 1, to, truth, noise, random));
    world.graph.poses.push_back(world.graph.poses.back() * world.graph.edges.back().T_from_to);
  }
  world.graph.fixed = {0};
  world.truth = std::move(truth);
  return world;
}

/// Blocks of houses: a robot that goes 1 m at a time, now and then turns left or right, and has a
/// place again that it has been to. About one loop closure for two steps.
inline World Manhattan(int poses, std::uint32_t seed, const MotionNoise& noise = {0.05, 0.01}) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr int kStepsToCorner = 4;
  const double half_side = 0.35 * std::sqrt(poses);
  std::vector<Pose2> truth = {{0, 0, 0}};
  while (static_cast<int>(truth.size()) < poses) {
    Pose2 next = truth.back() * Pose2{1, 0, 0};
    if (truth.size() % kStepsToCorner == 0) {
      const double choice = unit(random);
      const double turn = choice < 0.35 ? 0.5 : choice < 0.7 ? -0.5 : 0;
      next = next * Pose2{0, 0, turn * std::numbers::pi};
    }
    const bool outside = std::abs((next * Pose2{kStepsToCorner, 0, 0}).x) > half_side ||
                         std::abs((next * Pose2{kStepsToCorner, 0, 0}).y) > half_side;
    if (outside && truth.size() % kStepsToCorner == 0) {
      next = next * Pose2{0, 0, std::numbers::pi / 2};
    }
    truth.push_back(next);
  }
  World world = Drive(std::move(truth), noise, random);
  std::map<std::pair<int, int>, std::vector<std::int64_t>> visits;
  for (std::int64_t i = 0; i < poses; ++i) {
    const Pose2& at = world.truth[i];
    auto& earlier = visits[{std::lround(at.x), std::lround(at.y)}];
    if (!earlier.empty() && unit(random) < 0.7) {
      const auto pick = static_cast<std::size_t>(unit(random) * earlier.size());
      if (earlier[pick] < i - 10) {
        world.graph.edges.push_back(MeasuredEdge(earlier[pick], i, world.truth, noise, random));
      }
    }
    earlier.push_back(i);
  }
  return world;
}

/// A hall driven up and down: lanes of keyframes 0.5 m apart, each keyframe seen from the up to
/// three nearest of the lane before.
inline World Lawnmower(int lanes,
                       int per_lane,
                       std::uint32_t seed,
                       const MotionNoise& odometry = {0.004, 0.001},
                       const MotionNoise& closure = {0.006, 0.0015}) {
  constexpr double kSpacing = 0.5;
  std::mt19937 random(seed);
  std::vector<Pose2> truth;
  for (int lane = 0; lane < lanes; ++lane) {
    const bool back = lane % 2 == 1;
    for (int i = 0; i < per_lane; ++i) {
      truth.push_back(
          {kSpacing * (back ? per_lane - 1 - i : i), kSpacing * lane, back ? std::numbers::pi : 0});
    }
  }
  World world = Drive(std::move(truth), odometry, random);
  for (int lane = 1; lane < lanes; ++lane) {
    for (int i = 0; i < per_lane; ++i) {
      for (int side = -1; side <= 1; ++side) {
        const int beside =
            per_lane - 1 - i + side;  // the lane before was driven in the other direction
        if (beside < 0 || beside >= per_lane) continue;
        const std::int64_t from = (lane - 1) * per_lane + beside;
        const std::int64_t to = lane * per_lane + i;
        if (to - from < 2) continue;
        world.graph.edges.push_back(MeasuredEdge(from, to, world.truth, closure, random));
      }
    }
  }
  return world;
}

}  // namespace ceilmap::graph::synthetic
