#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/page/page_data.hpp"
#include "app/reports/page_parts.hpp"
#include "app/reports/report_table.hpp"
#include "app/terminal/summary.hpp"
#include "app/terminal/table.hpp"
#include "mapping/graph/keyframe.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::reports {

/// The report of a run of `map` or `localize`: `--report DIR`.

struct RunRecord {
  std::string name;                              ///< name of the recording, e.g. "up.mp4"
  std::string title;                             ///< title of the page, e.g. "Map lab.gpkg"
  std::vector<graph::FramePose> frames;          ///< with or without a pose, by increasing stamps
  std::vector<std::array<double, 2>> footprint;  ///< of the camera, see page::PagePath
  std::optional<PageSite> site;  ///< the page has these coordinates; frames have those of the map
};

/// The footprint in the unit of the page: that of the building is the metre.
std::vector<std::array<double, 2>> ShownFootprint(const RunRecord& run);

/// The page of a run: its path on the map, the content of the map, and charts of the run.
page::PageData PageOf(const RunRecord& run, const store::MapReader& map);

/// Names of the printed results in files.
ReportTable FactsTable(const std::string& title, const terminal::Table& facts);

/// Writes index.html (the page), metrics.json, tables.md, tables.tex and figures/. Without gnuplot
/// there are no figures, and a warning is printed.
/// @param folder  Checked by files::CheckOutputFolder before the run. @param page  The page.
/// @param summary  The files are added to it; its results are those of metrics.json.
/// @throws RunError when the disk cannot be written.
void WriteRunReport(const std::filesystem::path& folder,
                    const RunRecord& run,
                    const page::PageData& page,
                    const store::MapReader& map,
                    const std::vector<ReportTable>& tables,
                    terminal::Summary& summary);

/// Prints results on stdout, then the files of a run.
void PrintFacts(const terminal::Table& facts, const terminal::Summary& summary);

}  // namespace ceilmap::reports
