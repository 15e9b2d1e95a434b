#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "calib/base/heading.hpp"
#include "mapping/loop_closer.hpp"
#include "tests/mapping/synthetic_drive.hpp"

/// A robot with accurate odometry, except for one step with hardly any: places must
/// be found by their appearance.
namespace ceilmap::mapping::synthetic {

/// Where the robot takes a keyframe.
struct Stop {
  Pose2 T_map_base;
  Pose2 appears_at;      ///< where the ceiling has the appearance of this place
  double sigma = 0.002;  ///< of the path from the stop before, m; the path itself is true
  double sigma_rad = 0.0005;
  std::optional<HeadingPrior> heading = {};
};

/// Stops that are shown to a loop closer one after the other, ids 0, 1, ...
class Stops {
 public:
  explicit Stops(const CeilingParams& ceiling, const LoopCloserParams& params = ShortGap())
      : ceiling_(ceiling),
        closer_(
            view_, [this](std::int64_t id) { return Image(id); }, params) {}

  void Show(const Stop& stop) {
    const auto id = static_cast<std::int64_t>(stops_.size());
    stops_.push_back(stop);
    graph::Keyframe keyframe;
    keyframe.id = id;
    keyframe.pose.T_map_base = stop.T_map_base;
    keyframe.pose.heading = stop.heading;
    std::vector<graph::Edge> ties;
    if (id > 0) {
      const double xy = 1 / (stop.sigma * stop.sigma);
      graph::Edge tie{id - 1, id, graph::Edge::Kind::kOdometry, Between(id - 1, id), {}};
      tie.information = Eigen::Vector3d(xy, xy, 1 / (stop.sigma_rad * stop.sigma_rad)).asDiagonal();
      ties.push_back(tie);
    }
    closer_.Add(keyframe, {}, ties, describer_.Describe(Image(id)));
    closer_.Close(id);
  }

  [[nodiscard]] graph::LoopCounts Counts() const { return closer_.Counts(); }
  /// How far the worst edge is from the truth: metres.
  [[nodiscard]] double WorstEdge() const {
    double worst = 0;
    for (const graph::Edge& edge : closer_.Graph().Edges()) {
      const Pose2 off = edge.T_from_to.Inverse() * Between(edge.from, edge.to);
      worst = std::max(worst, off.Translation().norm());
    }
    return worst;
  }

  /// Every earlier keyframe but the last two may be found again.
  static LoopCloserParams ShortGap() {
    LoopCloserParams params;
    params.candidates.min_keyframe_gap = 3;
    return params;
  }

 private:
  [[nodiscard]] const Stop& At(std::int64_t id) const {
    return stops_[static_cast<std::size_t>(id)];
  }
  [[nodiscard]] Pose2 Between(std::int64_t from, std::int64_t to) const {
    return At(from).T_map_base.Inverse() * At(to).T_map_base;
  }
  [[nodiscard]] cv::Mat Image(std::int64_t id) const {
    return ceiling_.Render(
        view_.Size(), MotionAt(view_, At(id).appears_at), 1.5, static_cast<std::uint32_t>(id) + 1);
  }

  SyntheticCeiling ceiling_;
  calib::CeilingView view_ = SmallView();
  places::PlaceDescriber describer_{
      view_.Size(),
      view_.MetresPerPixel(),
      places::PlaceDescriptorParams::ForCamera(view_.Size(), view_.MetresPerPixel())};
  std::vector<Stop> stops_;
  LoopCloser closer_;
};

}  // namespace ceilmap::mapping::synthetic
