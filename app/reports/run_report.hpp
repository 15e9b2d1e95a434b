#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "app/page/page_data.hpp"
#include "app/reports/report_table.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::reports {

/// What a run of `map` or `localize` leaves to look at: `--report DIR`.

struct RunRecord {
  std::string name;                              ///< of the recording, e.g. "up.mp4"
  std::string title;                             ///< of the page, e.g. "Map lab.gpkg"
  std::vector<graph::FramePose> frames;          ///< all, placed or not, by rising stamps
  std::vector<std::array<double, 2>> footprint;  ///< of the camera, see page::PagePath
};

/// The page of a run: its path on the map, with all that the map has, and charts of the run alone.
page::PageData PageOf(const RunRecord& run, const store::MapReader& map);

/// What a run's facts, as they are printed, are called in files.
ReportTable FactsTable(const std::string& title, const terminal::Table& facts);

/// Writes index.html (the page), metrics.json, tables.md, tables.tex and figures/. Without gnuplot
/// there are no figures, and a warning tells.
/// @param folder  checked by CheckReportFolder before the run. @param page  the page.
/// @param summary  gets the files; its figures are those of metrics.json.
/// @throws RunError when the disk refuses.
void WriteRunReport(const std::filesystem::path& folder,
                    const RunRecord& run,
                    const page::PageData& page,
                    const store::MapReader& map,
                    const std::vector<ReportTable>& tables,
                    terminal::Summary& summary);

/// Facts on stdout, then the files that a run wrote.
void PrintFacts(const terminal::Table& facts, const terminal::Summary& summary);

}  // namespace ceilmap::reports
