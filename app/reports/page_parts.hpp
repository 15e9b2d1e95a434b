#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/page/page_data.hpp"
#include "app/reports/report_table.hpp"
#include "calib/ceiling_view.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/graph/map_graph.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::reports {

/// From what the program knows to what a page shows of it.

/// NaN for a frame that was not placed.
page::PagePose ToPagePose(const graph::FramePose& frame);

/// A run's frames, placed or not. @param frames  by rising stamps.
page::PagePath ToPagePath(const std::string& name, const std::vector<graph::FramePose>& frames);

/// Corners of what the camera sees of a level ceiling, in base.
std::vector<std::array<double, 2>> FootprintOf(const calib::CeilingView& view);

/// Keyframes, edges and weak spots of a map. @param unit  of the map, "m" or "px".
void AddGraph(const graph::MapGraph& graph, page::PageData& data);
/// The same of a map file, and its mosaic.
void AddMap(const store::MapReader& map, page::PageData& data);

void AddTables(const std::vector<ReportTable>& tables, page::PageData& data);

/// Charts of a run by itself: yaw (going on beyond 180 degrees), standard deviations of position
/// and yaw, and pitch and roll where it was ever tilted.
/// @param frames  by rising stamps.
std::vector<page::PageChart> ChartsOfRun(const std::string& name,
                                         const std::vector<graph::FramePose>& frames,
                                         const std::string& unit);

}  // namespace ceilmap::reports
