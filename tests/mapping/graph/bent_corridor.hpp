#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "mapping/graph/control_points.hpp"

/// A map that is bent because nothing contradicts it.
namespace ceilmap::graph::synthetic {

inline constexpr double kStep = 0.5;
inline constexpr int kKeyframes = 121;  // 60 m

/// A drive along a straight corridor without loops. Its edges have noise and, in addition, a turn
/// of 0.03 degrees each that their covariances do not contain: the map is bent.
class Corridor {
 public:
  explicit Corridor(unsigned seed, double bend_rad = 0.0005) : random_(seed) {
    constexpr double kSigma = 0.0003;
    constexpr double kSigmaYaw = 0.0001;
    for (int i = 0; i < kKeyframes; ++i) {
      truth.push_back({kStep * i, 0, 0});
      Keyframe keyframe;
      keyframe.id = i;
      keyframe.pose.keyframe_id = i;
      keyframe.pose.frame_index = 5 * i;
      keyframe.pose.T_map_base =
          i == 0 ? truth[0]
                 : graph.keyframes.back().pose.T_map_base * Measured(kSigma, kSigmaYaw, bend_rad);
      if (i > 0) {
        Edge edge{i - 1, i, Edge::Kind::kOdometry, {}, {}};
        edge.T_from_to =
            graph.keyframes.back().pose.T_map_base.Inverse() * keyframe.pose.T_map_base;
        edge.information =
            Eigen::Vector3d(
                1 / (kSigma * kSigma), 1 / (kSigma * kSigma), 1 / (kSigmaYaw * kSigmaYaw))
                .asDiagonal();
        graph.edges.push_back(edge);
      }
      graph.keyframes.push_back(keyframe);
      graph.trajectory.push_back(keyframe.pose);
    }
    Optimize(graph);
  }

  /// A point 1 m to the left of every tenth keyframe, picked and surveyed with this noise.
  std::vector<ControlMeasurement> Points(double sigma_m) {
    std::vector<ControlMeasurement> points;
    for (int i = 0; i < kKeyframes; i += 10) {
      const Eigen::Vector2d p_base(0.1, 1);
      points.push_back({i,
                        p_base,
                        site * (truth[static_cast<std::size_t>(i)] * p_base) + Noise(sigma_m),
                        sigma_m});
    }
    return points;
  }

  /// Largest distance of a keyframe from the line between the first and the last.
  [[nodiscard]] double Bend() const {
    const Eigen::Vector2d first = graph.keyframes.front().pose.T_map_base.Translation();
    const Eigen::Vector2d along =
        (graph.keyframes.back().pose.T_map_base.Translation() - first).normalized();
    double bend = 0;
    for (const Keyframe& keyframe : graph.keyframes) {
      const Eigen::Vector2d p = keyframe.pose.T_map_base.Translation() - first;
      bend = std::max(bend, std::abs(along.x() * p.y() - along.y() * p.x()));
    }
    return bend;
  }
  [[nodiscard]] double Length() const {
    return (graph.keyframes.back().pose.T_map_base.Translation() -
            graph.keyframes.front().pose.T_map_base.Translation())
        .norm();
  }

  MapGraph graph;
  std::vector<Pose2> truth;
  const Similarity2 site{{691'000, 5'335'000, 0.7}, 1};

 private:
  Eigen::Vector2d Noise(double sigma) {
    return sigma * Eigen::Vector2d(normal_(random_), normal_(random_));
  }
  Pose2 Measured(double sigma, double sigma_yaw, double bend) {
    const Eigen::Vector2d noise = Noise(sigma);
    return {kStep + noise.x(), noise.y(), bend + sigma_yaw * normal_(random_)};
  }

  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace ceilmap::graph::synthetic
