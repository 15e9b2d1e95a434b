#include "app/reports/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/files/tum.hpp"
#include "app/page/page.hpp"
#include "app/reports/comparison_figures.hpp"
#include "app/reports/report_folder.hpp"

namespace fs = std::filesystem;

namespace ceilmap::reports {
namespace {

figures::TrajectoryComparison FiguresOf(const RunRecord& run) {
  std::vector<StampedPose> poses;
  poses.reserve(run.frames.size());
  for (const graph::FramePose& frame : run.frames) {
    if (graph::HasPose(frame.status))
      poses.push_back(ToStampedPose(frame.stamp_s, frame.T_map_base, frame.tilt));
  }
  figures::TrajectoryComparison comparison;
  comparison.runs.push_back({run.name, FigurePoses(poses), {}});
  return comparison;
}

}  // namespace

ReportTable FactsTable(const std::string& title, const terminal::Table& facts) {
  ReportTable table{title, {"", "value", ""}, facts.Rows()};
  for (auto& row : table.rows) row.resize(table.columns.size());
  return table;
}

std::vector<std::array<double, 2>> ShownFootprint(const RunRecord& run) {
  std::vector<std::array<double, 2>> footprint = run.footprint;
  const double scale = run.site ? run.site->frame.S_site_map.scale : 1;
  for (auto& [x, y] : footprint) {
    x *= scale;
    y *= scale;
  }
  return footprint;
}

page::PageData PageOf(const RunRecord& run, const store::MapReader& map) {
  page::PageData data;
  data.title = run.title;
  AddMap(map, run.site, data);
  std::vector<graph::FramePose> frames = run.frames;
  if (run.site) {
    for (graph::FramePose& frame : frames) frame = InSite(run.site->frame, frame);
  }
  data.paths.push_back(ToPagePath(run.name, frames));
  data.paths.back().footprint = ShownFootprint(run);
  data.charts = ChartsOfRun(run.name, frames, data.unit);
  return data;
}

void WriteRunReport(const fs::path& folder,
                    const RunRecord& run,
                    const page::PageData& page,
                    const store::MapReader& map,
                    const std::vector<ReportTable>& tables,
                    terminal::Summary& summary) {
  using Handler = nlohmann::ordered_json::error_handler_t;
  const std::vector<fs::path> files =
      WriteReport(folder,
                  {{"index.html", page::WritePage(page)},
                   {"metrics.json", summary.quality.dump(2, ' ', false, Handler::replace) + "\n"},
                   {"tables.md", FormatMarkdown(tables)},
                   {"tables.tex", FormatLatex(tables)}});
  summary.files.insert(summary.files.end(), files.begin(), files.end());
  const auto has_pose = [](const graph::FramePose& frame) { return graph::HasPose(frame.status); };
  if (std::none_of(run.frames.begin(), run.frames.end(), has_pose)) return;
  DrawTrajectoryFigures(FiguresOf(run), &map, folder / "figures", summary);
}

void PrintFacts(const terminal::Table& facts, const terminal::Summary& summary) {
  fmt::print("{}", facts.Format());
  for (const fs::path& file : summary.files) fmt::print("written {}\n", file.string());
}

}  // namespace ceilmap::reports
