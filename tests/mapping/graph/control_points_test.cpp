#include "mapping/graph/control_points.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calib/base/error.hpp"

namespace ceilmap::graph {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kStep = 0.5;
constexpr int kKeyframes = 121;  // 60 m

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
  const Similarity2 site{1, {691'000, 5'335'000, 0.7}};

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

TEST(Straighten, ABentCorridorBecomesStraight) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Corridor corridor(seed);
    EXPECT_GT(corridor.Bend(), 0.4);
    Straighten(corridor.graph, corridor.Points(0.002), corridor.site);
    // What is left is the curvature between two points: 3 mm by geometry, and their noise.
    EXPECT_LT(corridor.Bend(), 0.008) << seed;
    // The direction at the ends is known to some milliradians, and the points lie 1 m aside.
    EXPECT_NEAR(corridor.Length(), 60, 0.02) << seed;
  }
}

TEST(Straighten, ExactPointsOfAStraightMapChangeNothing) {
  Corridor corridor(3, 0);
  const std::vector<Pose2> before = PosesById(corridor.graph);
  std::vector<ControlMeasurement> points;
  for (const std::int64_t id : {0, 40, 80, 120}) {
    const Eigen::Vector2d p_base(0, 1);
    points.push_back(
        {id, p_base, corridor.site * (before[static_cast<std::size_t>(id)] * p_base), 0.01});
  }
  Straighten(corridor.graph, points, corridor.site);
  const std::vector<Pose2> after = PosesById(corridor.graph);
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR((before[i].Translation() - after[i].Translation()).norm(), 0, 1e-6);
  }
}

TEST(Straighten, AWrongPointIsNotUsed) {
  Corridor corridor(4, 0.00005);
  std::vector<ControlMeasurement> points = corridor.Points(0.003);
  Corridor same(4, 0.00005);
  std::vector<ControlMeasurement> without = points;
  without.erase(without.begin() + 3);
  points[3].p_site.x() += 0.5;
  const std::vector<bool> used = Straighten(corridor.graph, points, corridor.site);
  for (std::size_t i = 0; i < used.size(); ++i) EXPECT_EQ(used[i], i != 3) << i;
  Straighten(same.graph, without, same.site);
  for (std::size_t i = 0; i < corridor.graph.keyframes.size(); ++i) {
    EXPECT_NEAR((corridor.graph.keyframes[i].pose.T_map_base.Translation() -
                 same.graph.keyframes[i].pose.T_map_base.Translation())
                    .norm(),
                0,
                1e-6);
  }
}

TEST(Straighten, FramesFollowTheirKeyframes) {
  Corridor corridor(5);
  Straighten(corridor.graph, corridor.Points(0.003), corridor.site);
  for (std::size_t i = 0; i < corridor.graph.keyframes.size(); ++i) {
    const Pose2& keyframe = corridor.graph.keyframes[i].pose.T_map_base;
    const Pose2& frame = corridor.graph.trajectory[i].T_map_base;
    EXPECT_NEAR((keyframe.Translation() - frame.Translation()).norm(), 0, 1e-9);
  }
  EXPECT_TRUE(corridor.graph.keyframes.back().pose.covariance.allFinite());
}

TEST(Straighten, RefusesAPointOfAMissingKeyframe) {
  Corridor corridor(6);
  const std::vector<ControlMeasurement> points = {{999, {0, 0}, {1, 2}, 0.01}};
  EXPECT_THAT([&] { Straighten(corridor.graph, points, corridor.site); },
              ThrowsMessage<InputError>(HasSubstr("keyframe 999")));
}

}  // namespace
}  // namespace ceilmap::graph
