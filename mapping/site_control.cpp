#include "mapping/site_control.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <unordered_map>

#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/graph/control_points.hpp"

namespace ceilmap::mapping {
namespace {

/// A point in the keyframe whose image shows it.
struct SeenPoint {
  std::int64_t keyframe_id = 0;
  Eigen::Vector2d p_base = Eigen::Vector2d::Zero();
};

SeenPoint NearestView(const graph::MapGraph& graph,
                      const survey::ControlPoint& point,
                      double reach) {
  double nearest = std::numeric_limits<double>::infinity();
  SeenPoint seen;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    const Eigen::Vector2d p_base = keyframe.pose.T_map_base.Inverse() * point.p_map;
    if (p_base.norm() >= nearest) continue;
    nearest = p_base.norm();
    seen = {keyframe.id, p_base};
  }
  if (!(nearest <= reach)) {
    throw InputError(fmt::format("point '{}' at {:.3f}, {:.3f} lies outside the map",
                                 Shown(point.name),
                                 point.p_map.x(),
                                 point.p_map.y()));
  }
  return seen;
}

/// Where the keyframes now have the points.
std::vector<survey::ControlPoint> Moved(const graph::MapGraph& graph,
                                        const std::vector<SeenPoint>& seen,
                                        std::vector<survey::ControlPoint> points) {
  std::unordered_map<std::int64_t, const Pose2*> poses;
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    poses[keyframe.id] = &keyframe.pose.T_map_base;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].p_map = *poses.at(seen[i].keyframe_id) * seen[i].p_base;
  }
  return points;
}

/// The points that an alignment uses.
std::vector<graph::ControlMeasurement> Measurements(
    const survey::SiteFrame& site,
    const std::vector<SeenPoint>& seen,
    const std::vector<survey::ControlPoint>& points) {
  std::vector<graph::ControlMeasurement> measurements;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!site.points[i].used) continue;
    measurements.push_back(
        {seen[i].keyframe_id, seen[i].p_base, points[i].p_site, points[i].sigma_m});
  }
  return measurements;
}

bool UsesTheSame(const survey::SiteFrame& a, const survey::SiteFrame& b) {
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    if (a.points[i].used != b.points[i].used) return false;
  }
  return true;
}

/// The alignment of a map that may be bent by this fraction of its size.
survey::Alignment AlignBent(std::vector<survey::ControlPoint> points,
                            const survey::AlignOptions& params) {
  constexpr double kBend = 0.005;
  Eigen::AlignedBox2d box;
  for (const survey::ControlPoint& point : points) box.extend(point.p_site);
  const double bend_m = points.empty() ? 0 : kBend * box.diagonal().norm();
  for (survey::ControlPoint& point : points) point.sigma_m = std::max(point.sigma_m, bend_m);
  return survey::Align(points, params);
}

}  // namespace

survey::Alignment ControlMap(graph::MapGraph& graph,
                             const std::vector<survey::ControlPoint>& picked,
                             double reach,
                             const survey::AlignOptions& align,
                             const graph::PoseGraphParams& pose_graph) {
  std::vector<survey::ControlPoint> points = picked;
  std::vector<SeenPoint> seen;
  for (survey::ControlPoint& point : points) {
    if (point.sigma_m == 0) point.sigma_m = align.sigma_m;
    seen.push_back(NearestView(graph, point, reach));
  }
  const graph::MapGraph before = graph;
  survey::Alignment alignment = AlignBent(points, align);
  // A bend can hide a wrong point, and exclude good ones at its ends: those that agree with the
  // straightened map are used in the next round.
  constexpr int kMaxRounds = 5;
  for (int round = 0; round < kMaxRounds; ++round) {
    graph = before;
    graph::Straighten(
        graph, Measurements(alignment.site, seen, points), alignment.site.S_site_map, pose_graph);
    survey::Alignment next = survey::Align(Moved(graph, seen, points), align);
    const bool settled = UsesTheSame(next.site, alignment.site);
    alignment = std::move(next);
    if (settled) break;
  }
  return alignment;
}

}  // namespace ceilmap::mapping
