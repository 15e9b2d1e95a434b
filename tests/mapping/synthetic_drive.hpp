#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "calib/base/pose_with_covariance.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/places/place_descriptor.hpp"
#include "mapping/planar_motion.hpp"
#include "tests/mapping/registration/synthetic_ceiling.hpp"

/// Keyframes of a robot under a synthetic ceiling, with an odometry whose errors are known, for the
/// tests of loop closing and merging.
namespace ceilmap::mapping::synthetic {

using registration::synthetic::CeilingParams;
using registration::synthetic::MotionAt;
using registration::synthetic::SyntheticCeiling;

/// 320 x 240 px of 10 mm: 3.2 m x 2.4 m of ceiling in view.
inline calib::CeilingView SmallView() {
  calib::MountedCamera up;
  up.camera = {320, 240, 220, 220, 159.5, 119.5, {}};
  up.T_base_cam.linear() =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(0.05, 0, 0.4);
  return {up, 2.6};
}

/// A camera of another size, height and lens, mounted elsewhere and turned: 300 x 280 px of 8 mm.
inline calib::CeilingView OtherView() {
  calib::MountedCamera up;
  up.camera = {300, 280, 200, 200, 149.5, 139.5, {}};
  up.T_base_cam.linear() = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  up.T_base_cam.translation() = Eigen::Vector3d(-0.1, 0.07, 1.0);
  return {up, 2.6};
}

/// Metres per pixel of the ceiling, at which SmallView shows it.
inline constexpr double kCeilingUnit = 0.01;

/// Identical tiles.
inline CeilingParams Periodic(double tile_px) {
  CeilingParams params;
  params.tile_px = tile_px;
  params.tile_grey = 0;
  params.speckle_grey = 0;
  params.lamps = false;
  params.marks = false;
  return params;
}

/// A hall with four identical arms: after a quarter turn about its middle it fits again.
inline CeilingParams FourArms() {
  CeilingParams arms = Periodic(0);
  std::uint32_t state = 5;
  const auto next = [&state] {
    state = state * 1664525 + 1013904223;
    return static_cast<double>(state >> 8U) / (1U << 24U);
  };
  for (int i = 0; i < 60; ++i) {
    Eigen::Vector2d p(60 + 900 * next(), 300 * (next() - 0.5));
    for (int quarter = 0; quarter < 4; ++quarter) {
      arms.own_marks.push_back(p);
      p = Eigen::Vector2d(-p.y(), p.x());
    }
  }
  return arms;
}

struct DriftParams {
  double sigma = 0.002;       ///< of an edge, in x and y; the edges claim it
  double sigma_rad = 0.0005;  ///< the same in yaw
  double yaw_bias_rad = 0;    ///< of each edge; the edges do not know
};

/// Keyframes at given places, tied from one to the next.
class DriveUnder {
 public:
  DriveUnder(const CeilingParams& ceiling,
             const std::vector<Pose2>& truths,
             const DriftParams& drift = {},
             std::int64_t first_id = 0,
             const calib::CeilingView& camera_view = SmallView())
      : view(camera_view),
        ceiling_(ceiling),
        drift_(drift),
        random_(7 + static_cast<unsigned>(first_id)) {
    for (std::size_t i = 0; i < truths.size(); ++i) {
      const std::int64_t id = first_id + static_cast<std::int64_t>(i);
      truth[id] = truths[i];
      graph::Keyframe keyframe;
      keyframe.id = id;
      keyframe.pose.keyframe_id = id;
      if (i > 0) {
        graph::Edge tie = Tie(id - 1, id);
        const graph::FramePose& before = graph.keyframes.back().pose;
        keyframe.pose.T_map_base = before.T_map_base * tie.T_from_to;
        keyframe.pose.covariance = ComposeCovariance(
            before.T_map_base, before.covariance, tie.T_from_to, tie.information.inverse());
        graph.edges.push_back(tie);
      }
      graph.keyframes.push_back(keyframe);
      graph.trajectory.push_back(keyframe.pose);
    }
  }

  [[nodiscard]] cv::Mat Image(std::int64_t id) const {
    registration::ImageMotion motion = MotionAt(view, truth.at(id));
    motion.scale = kCeilingUnit / view.MetresPerPixel();
    return ceiling_.Render(view.Size(), motion, 1.5, static_cast<std::uint32_t>(id) + 1);
  }
  [[nodiscard]] cv::Mat Descriptors(std::int64_t id) const {
    places::PlaceDescriber describer(
        view.Size(),
        view.MetresPerPixel(),
        places::PlaceDescriptorParams::ForCamera(view.Size(), view.MetresPerPixel()));
    return describer.Describe(Image(id));
  }
  /// How far an edge is from the truth: metres.
  [[nodiscard]] double Error(const graph::Edge& edge) const {
    const Pose2 off =
        edge.T_from_to.Inverse() * (truth.at(edge.from).Inverse() * truth.at(edge.to));
    return off.Translation().norm();
  }

  calib::CeilingView view;
  std::map<std::int64_t, Pose2> truth;
  graph::MapGraph graph;  ///< as the odometry has it

 private:
  graph::Edge Tie(std::int64_t from, std::int64_t to) {
    graph::Edge edge{from, to, graph::Edge::Kind::kOdometry, truth[from].Inverse() * truth[to], {}};
    edge.T_from_to.x += drift_.sigma * normal_(random_);
    edge.T_from_to.y += drift_.sigma * normal_(random_);
    edge.T_from_to.yaw += drift_.sigma_rad * normal_(random_) + drift_.yaw_bias_rad;
    const double xy = 1 / (drift_.sigma * drift_.sigma);
    edge.information =
        Eigen::Vector3d(xy, xy, 1 / (drift_.sigma_rad * drift_.sigma_rad)).asDiagonal();
    return edge;
  }

  SyntheticCeiling ceiling_;
  DriftParams drift_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

/// Places `step` apart along a square of side `side`, `laps` times, the robot facing ahead.
inline std::vector<Pose2> Square(double side, double step, int laps) {
  std::vector<Pose2> places;
  const int per_side = static_cast<int>(std::lround(side / step));
  for (int i = 0; i < 4 * per_side * laps; ++i) {
    const int corner = i / per_side % 4;
    const double along = (i % per_side) * step;
    Pose2 T{0, 0, corner * std::numbers::pi / 2};
    const std::vector<Eigen::Vector2d> corners = {{0, 0}, {side, 0}, {side, side}, {0, side}};
    const Eigen::Vector2d p =
        corners[static_cast<std::size_t>(corner)] + T.Rotation() * Eigen::Vector2d(along, 0);
    places.push_back({p.x(), p.y(), WrapAngle(T.yaw)});
  }
  return places;
}

}  // namespace ceilmap::mapping::synthetic
