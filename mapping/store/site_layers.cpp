#include "mapping/store/site_layers.hpp"

namespace ceilmap::store {
namespace {

void MoveToSite(const survey::SiteFrame& site, graph::FramePose& frame) {
  const PoseWithCovariance pose = survey::ToSite(site, {frame.T_map_base, frame.covariance});
  frame.T_map_base = pose.pose;
  frame.covariance = pose.covariance;
}

}  // namespace

graph::MapGraph InSite(const survey::SiteFrame& site, graph::MapGraph graph) {
  const double scale = site.S_site_map.scale;
  for (graph::Keyframe& keyframe : graph.keyframes) MoveToSite(site, keyframe.pose);
  for (graph::FramePose& frame : graph.trajectory) MoveToSite(site, frame);
  const Eigen::Vector3d per_site(1 / scale, 1 / scale, 1);
  for (graph::Edge& edge : graph.edges) {
    edge.T_from_to.x *= scale;
    edge.T_from_to.y *= scale;
    edge.information = per_site.asDiagonal() * edge.information * per_site.asDiagonal();
  }
  for (graph::WeakSpot& spot : graph.weak_spots) {
    const Eigen::Vector2d place = site.S_site_map * Eigen::Vector2d(spot.x, spot.y);
    spot.x = place.x();
    spot.y = place.y();
    if (spot.kind != graph::WeakSpot::Kind::kLost) spot.extent *= scale;  // else a number
  }
  return graph;
}

LeftOut InSite(const survey::SiteFrame& site, LeftOut places) {
  places.area *= site.S_site_map.scale * site.S_site_map.scale;
  for (auto& polygon : places.polygons) {
    for (auto& ring : polygon) {
      for (cv::Point2d& point : ring) {
        const Eigen::Vector2d place = site.S_site_map * Eigen::Vector2d(point.x, point.y);
        point = {place.x(), place.y()};
      }
    }
  }
  return places;
}

}  // namespace ceilmap::store
