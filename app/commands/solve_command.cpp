#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/commands/map_inputs.hpp"
#include "app/commands/point_options.hpp"
#include "app/reports/alignment_report.hpp"
#include "app/reports/map_quality.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/progress.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/error.hpp"
#include "mapping/edges_file.hpp"
#include "mapping/map_solve.hpp"
#include "mapping/site_control.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using nlohmann::ordered_json;

struct SolveOptions {
  UnionOptions maps;
  std::vector<fs::path> edges;
  PointOptions points;
  bool no_mosaic = false;

  [[nodiscard]] bool HasPoints() const { return !points.points.empty(); }
  void Check(files::Existing existing) const;
};

void SolveOptions::Check(files::Existing existing) const {
  // One map is solved alone: of a site with one recording, or to straighten it by control points.
  maps.Resolve("solve", existing, 1);
  if (maps.maps.size() > 1 && edges.empty()) {
    throw InputError("solve: give the files of 'ceilmap match' by --edges");
  }
  points.Check();
}

std::string FileName(const fs::path& file) {
  return file.filename().string();
}

void Warn(const mapping::SolvedMaps& solved, const std::vector<fs::path>& maps) {
  for (const auto& pair : solved.contradictions) {
    terminal::Warn("{} and {} are not connected: {}",
                   maps[pair.a].string(),
                   maps[pair.b].string(),
                   pair.reason);
  }
  for (const auto& alone : solved.left_out) {
    terminal::Warn("{} is left out: {}", maps[alone.map].string(), alone.reason);
  }
}

ordered_json Quality(const mapping::SolvedMaps& solved, const std::vector<fs::path>& maps) {
  ordered_json joined = ordered_json::array();
  for (const std::size_t map : solved.joined) joined.push_back(FileName(maps[map]));
  ordered_json left_out = ordered_json::array();
  for (const auto& alone : solved.left_out) left_out.push_back(FileName(maps[alone.map]));
  ordered_json contradictions = ordered_json::array();
  for (const auto& pair : solved.contradictions) {
    contradictions.push_back({FileName(maps[pair.a]), FileName(maps[pair.b])});
  }
  const graph::MapQuality& quality = solved.graph.quality;
  return {{"maps", maps.size()},
          {"joined", joined},
          {"left_out", left_out},
          {"contradictions", contradictions},
          {"keyframes", solved.graph.keyframes.size()},
          {"edges", solved.graph.edges.size()},
          {"loops", reports::ToJson(quality.loops)},
          {"chi2_per_dof", quality.chi2_per_dof},
          {"loop_rms", quality.loop_rms}};
}

void ReportSolved(const mapping::SolvedMaps& solved,
                  const UnionOptions& params,
                  const store::MapMetadata& metadata) {
  const graph::MapQuality& quality = solved.graph.quality;
  terminal::Table table;
  table.AddRow({"maps joined", fmt::format("{} of {}", solved.joined.size(), params.maps.size())});
  table.AddRow({"frame of", FileName(params.maps[solved.joined.front()])});
  table.AddRow({"keyframes", fmt::format("{}", solved.graph.keyframes.size())});
  table.AddRow(
      {"loops closed", fmt::format("{}", quality.loops.accepted - quality.loops.outliers)});
  table.AddRow({"they fit to", fmt::format("{:.2g}", quality.loop_rms), metadata.unit + " RMS"});
  if (metadata.site) {
    reports::AddSite(*metadata.site, table);
    fmt::print("{}\n", reports::FormatPlain(reports::PointsTable(*metadata.site)));
  }
  fmt::print("{}written {}\n", table.Format(), params.output.string());
}

// Straightens the map by the control points, which were picked on the map whose frame it has.
survey::SiteFrame Control(mapping::SolvedMaps& solved,
                          const MapInputs& inputs,
                          const SolveOptions& params,
                          terminal::Summary& summary) {
  const store::MapReader& first = *inputs.Maps()[solved.joined.front()].map;
  const cv::Size view = first.Metadata().view_size;
  const double reach = std::hypot(view.width, view.height) * first.Metadata().view_units_per_px;
  survey::AlignOptions align = params.points.params;
  align.estimate_scale = first.Metadata().unit == "px";
  const std::vector<survey::ControlPoint> points = params.points.Read(first.Grid());
  survey::Alignment alignment;
  try {
    alignment = mapping::ControlMap(solved.graph, points, reach, align);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", params.points.points.string(), error.what()));
  }
  alignment.site.crs_wkt = params.points.CrsWkt();
  for (const std::string& warning : reports::WarningsOf(alignment, first.Metadata().unit)) {
    terminal::PrintWarning(warning);
  }
  summary.quality["site"] = reports::ToJson(alignment.site);
  return alignment.site;
}

void RunSolve(const SolveOptions& params, const CommonOptions& common, terminal::Summary& summary) {
  params.Check(common.Existing());
  std::vector<mapping::NamedMatch> matches;
  for (const fs::path& file : params.edges) {
    matches.push_back({mapping::ReadEdges(file), file.string()});
  }
  const MapInputs inputs(params.maps.maps);
  auto start = std::chrono::steady_clock::now();
  mapping::SolvedMaps solved = mapping::SolveMaps(inputs.Maps(), matches);
  summary.stages_ms["solve"] = 1e3 * terminal::SecondsSince(start);
  Warn(solved, params.maps.maps);
  summary.quality = Quality(solved, params.maps.maps);
  if (solved.joined.empty()) {
    throw RunError(fmt::format("no two of the {} maps are connected; nothing was written",
                               params.maps.maps.size()));
  }
  std::vector<mapping::NamedMap> joined;
  for (const std::size_t map : solved.joined) joined.push_back(inputs.Maps()[map]);
  const mapping::CommonView view(joined);
  store::MapMetadata metadata = DescribeUnion(joined, view, params.maps.resolution, common);
  if (params.HasPoints()) metadata.site = Control(solved, inputs, params, summary);
  store::MapWriter writer(params.maps.output, metadata);
  inputs.CheckCurrent();
  start = std::chrono::steady_clock::now();
  if (params.no_mosaic) {
    static_cast<void>(mapping::WriteSolvedGraph(solved, inputs.Maps(), view, writer));
  } else {
    terminal::Progress progress("drawing", "tiles");
    mapping::WriteSolved(
        solved, inputs.Maps(), view, metadata, {}, writer, [&progress](int done, int total) {
          progress.Update(done, total);
        });
  }
  writer.Commit();
  summary.stages_ms[params.no_mosaic ? "write" : "draw"] = 1e3 * terminal::SecondsSince(start);
  summary.files = {params.maps.output};
  summary.frames = static_cast<std::int64_t>(solved.graph.trajectory.size());
  if (!common.quiet) ReportSolved(solved, params.maps, metadata);
}

}  // namespace

Command AddSolveCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "solve",
      "Makes one map of many that 'ceilmap match' has compared; maps that do not connect "
      "are left out and named. Control points (--points) place it in its building and straighten "
      "it.",
      "ceilmap solve east.gpkg west.gpkg --edges east-west.edges -o site.gpkg\n"
      "  ceilmap solve corridor.gpkg --points points.csv -o straight.gpkg");
  auto params = std::make_shared<SolveOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("maps",
                 params->maps.maps,
                 "The maps; the result has the frame of the first one that is connected")
      ->required()
      ->type_name("MAP.gpkg");
  cli.add_option("--edges", params->edges, "Files of 'ceilmap match', one for each pair of maps")
      ->type_name("AB.edges");
  params->points.AddTo(cli);
  cli.add_option("--resolution",
                 params->maps.resolution,
                 "Metres per map pixel [that of the first joined map]")
      ->type_name("M");
  cli.add_flag("--no-mosaic",
               params->no_mosaic,
               "Write the map without its mosaic, for 'ceilmap mosaic', which draws it in parts");
  cli.add_option("-o,--output", params->maps.output, "The map of all")
      ->required()
      ->type_name("SITE.gpkg");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunSolve(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
