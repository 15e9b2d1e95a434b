#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/commands/map_inputs.hpp"
#include "app/reports/map_quality.hpp"
#include "app/terminal/progress.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "mapping/map_union.hpp"

namespace ceilmap::commands {
namespace {

[[noreturn]] void Refuse(const mapping::MergeResult& merged, const UnionOptions& params) {
  for (std::size_t i = 1; i < merged.results.size(); ++i) {
    if (merged.results[i].ok()) continue;
    throw RunError(fmt::format(
        "{} cannot be joined with {}: {}; nothing was written",
        WithoutSecrets(params.maps[i].string()),
        merged.results.size() > 2 ? "the others" : WithoutSecrets(params.maps.front().string()),
        merged.results[i].reason));
  }
  throw RunError("the maps cannot be joined");
}

void Report(const mapping::MergeResult& merged,
            const UnionOptions& params,
            const std::string& unit) {
  terminal::Table table;
  for (std::size_t i = 1; i < merged.results.size(); ++i) {
    const mapping::JoinResult& join = merged.results[i];
    table.AddRow({WithoutSecrets(params.maps[i].filename().string()),
                  fmt::format("{} of {}", join.matched, join.expected),
                  "images agree where they must"});
  }
  const graph::MapQuality& quality = merged.graph.quality;
  table.AddRow({"keyframes", fmt::format("{}", merged.graph.keyframes.size())});
  table.AddRow(
      {"loops closed", fmt::format("{}", quality.loops.accepted - quality.loops.outliers)});
  table.AddRow({"they fit to", fmt::format("{:.2g}", quality.loop_rms), unit + " RMS"});
  fmt::print("{}written {}\n", table.Format(), params.output.string());
}

void RunMerge(const UnionOptions& params, const CommonOptions& common, terminal::Summary& summary) {
  params.Resolve("merge", common.Existing());
  const MapInputs inputs(params.maps);
  const mapping::CommonView view(inputs.Maps());
  const store::MapMetadata metadata = DescribeUnion(inputs.Maps(), view, params.resolution, common);
  store::MapWriter writer(params.output, metadata);
  inputs.CheckCurrent();
  mapping::MergeResult merged;
  {
    terminal::Progress progress("drawing", "tiles");
    merged = mapping::MergeMaps(
        inputs.Maps(), view, metadata, {}, writer, [&progress](int done, int total) {
          progress.Update(done, total);
        });
  }
  if (!merged.ok()) Refuse(merged, params);
  writer.Commit();
  summary.files = {params.output};
  summary.frames = static_cast<std::int64_t>(merged.graph.trajectory.size());
  summary.quality = {{"maps", params.maps.size()},
                     {"keyframes", merged.graph.keyframes.size()},
                     {"loops", reports::ToJson(merged.graph.quality.loops)},
                     {"chi2_per_dof", merged.graph.quality.chi2_per_dof},
                     {"loop_rms", merged.graph.quality.loop_rms}};
  if (!common.quiet) Report(merged, params, metadata.unit);
}

}  // namespace

Command AddMergeCommand(CLI::App& program) {
  Command command = MakeCommand(program,
                                "merge",
                                "Merges maps that overlap.",
                                "ceilmap merge east.gpkg west.gpkg -o site.gpkg");
  auto params = std::make_shared<UnionOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("maps", params->maps, "The maps; the result has the frame of the first one")
      ->required()
      ->type_name("MAP.gpkg");
  cli.add_option("--resolution", params->resolution, "Metres per map pixel [that of the first map]")
      ->type_name("M");
  cli.add_option("-o,--output", params->output, "The merged map")
      ->required()
      ->type_name("SITE.gpkg");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunMerge(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
