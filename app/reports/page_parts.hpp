#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "app/page/page_data.hpp"
#include "app/reports/report_table.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/survey/site_frame.hpp"

namespace ceilmap::reports {

/// Conversion of the program's data to the content of a page.

/// The coordinates of the building for a page, and its floor plan.
struct PageSite {
  survey::SiteFrame frame;
  page::PagePlan plan;  ///< may be empty
};

/// A frame of a run on the map, in the building. The covariance has the error of the alignment
/// added.
graph::FramePose InSite(const survey::SiteFrame& site, graph::FramePose frame);

/// NaN for a frame without a pose.
page::PagePose ToPagePose(const graph::FramePose& frame);

/// Frames of a run, with or without a pose. @param frames  By increasing stamps.
page::PagePath ToPagePath(const std::string& name, const std::vector<graph::FramePose>& frames);

/// Outline of a level ceiling in the camera's image, in base.
std::vector<std::array<double, 2>> FootprintOf(const calib::CeilingView& view);

/// Keyframes, edges and weak spots of a map, placed by data.S_page_map.
/// @param unit  Of the map, "m" or "px".
void AddGraph(const graph::MapGraph& graph, const std::string& unit, page::PageData& data);
/// The same for a map file, with its mosaic and its heights.
/// @param site  The page has these coordinates, in metres; nothing: those of the map, in its unit.
void AddMap(const store::MapReader& map, const std::optional<PageSite>& site, page::PageData& data);

void AddTables(const std::vector<ReportTable>& tables, page::PageData& data);

/// Charts of a run: yaw (continuous beyond 180 degrees), standard deviations of position and yaw,
/// and pitch and roll if it was ever tilted.
/// @param frames  By increasing stamps.
std::vector<page::PageChart> ChartsOfRun(const std::string& name,
                                         const std::vector<graph::FramePose>& frames,
                                         const std::string& unit);

}  // namespace ceilmap::reports
