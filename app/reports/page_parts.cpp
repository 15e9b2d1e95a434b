#include "app/reports/page_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "app/page/mosaic_picture.hpp"
#include "app/reports/map_quality.hpp"
#include "calib/base/degrees.hpp"
#include "mapping/mosaic/floor_heights.hpp"

namespace ceilmap::reports {
namespace {

using graph::FramePose;
using graph::TrackingStatus;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// A place that wheels alone tell is drawn too, with its uncertainty.
bool IsDrawn(const FramePose& frame) {
  return graph::HasPose(frame.status) || frame.status == TrackingStatus::kPredicted;
}

/// One value of each frame over time; NaN where it was not placed.
page::PageSeries OverTime(const std::string& name,
                          const std::vector<FramePose>& frames,
                          const std::function<double(const FramePose&)>& value) {
  page::PageSeries series;
  series.name = name;
  series.x.reserve(frames.size());
  series.y.reserve(frames.size());
  for (const FramePose& frame : frames) {
    series.x.push_back(frame.stamp_s);
    series.y.push_back(IsDrawn(frame) ? value(frame) : kUnknown);
  }
  return series;
}

page::PageChart TimeChart(std::string title, std::string y_label, page::PageSeries series) {
  page::PageChart chart;
  chart.title = std::move(title);
  chart.x_label = "time (s)";
  chart.y_label = std::move(y_label);
  chart.series.push_back(std::move(series));
  return chart;
}

/// At most `kMaxSide` cells on a side, over the mosaic.
page::PageHeights HeightsOf(const std::vector<graph::Keyframe>& keyframes,
                            const store::MapMetadata& metadata,
                            const store::MosaicGrid& whole) {
  constexpr int kMaxSide = 600;
  constexpr int kMosaicPixels = 4;  // a cell is not finer
  const mosaic::FloorHeights heights(keyframes, metadata);
  if (heights.empty() || whole.width_px == 0 || whole.height_px == 0) return {};
  const int side = std::max(whole.width_px, whole.height_px);
  const int factor = std::max(kMosaicPixels, (side + kMaxSide - 1) / kMaxSide);
  store::MosaicGrid grid = whole;
  grid.resolution *= factor;
  grid.width_px = (whole.width_px + factor - 1) / factor;
  grid.height_px = (whole.height_px + factor - 1) / factor;
  const cv::Mat metres = heights.Window(grid, {0, 0, grid.width_px, grid.height_px});
  if (cv::countNonZero(metres == metres) == 0) return {};
  page::PageHeights result{
      grid.width_px, grid.height_px, grid.min_x, grid.max_y, grid.resolution, {}};
  result.metres.assign(metres.begin<float>(), metres.end<float>());
  return result;
}

double PositionSigma(const FramePose& frame) {
  return std::sqrt(0.5 * (frame.covariance(0, 0) + frame.covariance(1, 1)));
}

}  // namespace

graph::FramePose InSite(const survey::SiteFrame& site, graph::FramePose frame) {
  if (!IsDrawn(frame)) return frame;
  const PoseWithCovariance pose = survey::ToSite(site, {frame.T_map_base, frame.covariance});
  frame.T_map_base = pose.pose;
  frame.covariance = pose.covariance;
  return frame;
}

page::PagePose ToPagePose(const FramePose& frame) {
  page::PagePose pose;
  pose.stamp_s = frame.stamp_s;
  pose.status = frame.status;
  if (!IsDrawn(frame)) {
    pose.x = pose.y = pose.yaw_rad = kUnknown;
    return pose;
  }
  pose.x = frame.T_map_base.x;
  pose.y = frame.T_map_base.y;
  pose.yaw_rad = frame.T_map_base.yaw;
  const Eigen::Matrix3d& covariance = frame.covariance;
  pose.covariance = {covariance(0, 0), covariance(0, 1), covariance(1, 1), covariance(2, 2)};
  return pose;
}

page::PagePath ToPagePath(const std::string& name, const std::vector<FramePose>& frames) {
  page::PagePath path;
  path.name = name;
  path.poses.reserve(frames.size());
  for (const FramePose& frame : frames) path.poses.push_back(ToPagePose(frame));
  return path;
}

std::vector<std::array<double, 2>> FootprintOf(const calib::CeilingView& view) {
  std::vector<std::array<double, 2>> corners;
  const double half_width = 0.5 * view.MetresPerPixel() * view.Size().width;
  const double half_height = 0.5 * view.MetresPerPixel() * view.Size().height;
  for (const auto& [u, v] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const Eigen::Vector2d p_base =
        view.T_base_view() * Eigen::Vector2d(u * half_width, v * half_height);
    corners.push_back({p_base.x(), p_base.y()});
  }
  return corners;
}

void AddGraph(const graph::MapGraph& graph, const std::string& unit, page::PageData& data) {
  data.keyframes.reserve(graph.keyframes.size());
  for (const graph::Keyframe& keyframe : graph.keyframes) {
    const Pose2 T_page_base = data.S_page_map * keyframe.pose.T_map_base;
    data.keyframes.push_back({keyframe.id, T_page_base.x, T_page_base.y, T_page_base.yaw});
  }
  data.edges.reserve(graph.edges.size());
  for (const graph::Edge& edge : graph.edges) {
    data.edges.push_back({edge.from, edge.to, edge.kind == graph::Edge::Kind::kLoopClosure});
  }
  for (const graph::WeakSpot& spot : graph.weak_spots) {
    const Eigen::Vector2d place = data.S_page_map * Eigen::Vector2d(spot.x, spot.y);
    data.spots.push_back({Describe(spot, unit), place.x(), place.y()});
  }
}

void AddMap(const store::MapReader& map,
            const std::optional<PageSite>& site,
            page::PageData& data) {
  data.unit = map.Metadata().unit;
  if (site) {
    data.unit = "m";
    data.S_page_map = site->frame.S_site_map;
    data.plan = site->plan;
  }
  data.picture = page::MakeMosaicPicture(map);
  const graph::MapGraph graph = map.ReadGraph();
  data.heights = HeightsOf(graph.keyframes, map.Metadata(), map.Grid());
  AddGraph(graph, map.Metadata().unit, data);
}

void AddTables(const std::vector<ReportTable>& tables, page::PageData& data) {
  for (const ReportTable& table : tables) {
    data.tables.push_back({table.title, table.columns, table.rows});
  }
}

std::vector<page::PageChart> ChartsOfRun(const std::string& name,
                                         const std::vector<FramePose>& frames,
                                         const std::string& unit) {
  const bool metres = unit == "m";
  double yaw_rad = 0;  // of the previous pose, continuous beyond 180 degrees
  std::vector<page::PageChart> charts = {
      TimeChart("Yaw",
                "yaw (deg)",
                OverTime(name,
                         frames,
                         [&yaw_rad](const FramePose& frame) {
                           yaw_rad +=
                               std::remainder(frame.T_map_base.yaw - yaw_rad, 2 * std::numbers::pi);
                           return kDegPerRad * yaw_rad;
                         })),
      TimeChart("Standard deviation of the position",
                metres ? "sigma (mm)" : "sigma (px)",
                OverTime(name,
                         frames,
                         [metres](const FramePose& frame) {
                           return (metres ? 1e3 : 1.0) * PositionSigma(frame);
                         })),
      TimeChart("Standard deviation of the yaw",
                "sigma (deg)",
                OverTime(name, frames, [](const FramePose& frame) {
                  return kDegPerRad * std::sqrt(frame.covariance(2, 2));
                }))};
  const bool tilted = std::any_of(frames.begin(), frames.end(), [](const FramePose& frame) {
    return frame.tilt.pitch_rad != 0 || frame.tilt.roll_rad != 0;
  });
  if (!tilted) return charts;
  page::PageChart tilt = TimeChart(
      "Pitch and roll", "angle (deg)", OverTime("pitch", frames, [](const FramePose& frame) {
        return kDegPerRad * frame.tilt.pitch_rad;
      }));
  tilt.series.push_back(OverTime(
      "roll", frames, [](const FramePose& frame) { return kDegPerRad * frame.tilt.roll_rad; }));
  charts.push_back(std::move(tilt));
  return charts;
}

}  // namespace ceilmap::reports
