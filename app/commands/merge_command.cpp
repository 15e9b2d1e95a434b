#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/files/output_files.hpp"
#include "app/reports/map_quality.hpp"
#include "app/terminal/progress.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "mapping/map_union.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct MergeCommandOptions {
  std::vector<fs::path> maps;
  std::optional<double> resolution;
  fs::path output;

  void Resolve(files::Existing existing) const {
    if (maps.size() < 2) throw InputError("merge: give at least two maps");
    if (output.extension() != ".gpkg") {
      throw InputError(fmt::format("{}: the map's name must end in .gpkg", output.string()));
    }
    if (resolution && !(*resolution > 0 && *resolution < 1e6)) {
      throw InputError(
          fmt::format("--resolution {}: must be > 0, metres per pixel of the map", *resolution));
    }
    files::CheckOutputFiles({output}, existing);
  }
};

store::MapMetadata Describe(const std::vector<std::unique_ptr<store::MapReader>>& maps,
                            const MergeCommandOptions& params,
                            const CommonOptions& common) {
  store::MapMetadata metadata = maps.front()->Metadata();
  for (std::size_t i = 1; i < maps.size(); ++i) {
    const std::string problem = mapping::Incompatibility(metadata, maps[i]->Metadata());
    if (!problem.empty()) {
      throw InputError(fmt::format("{} and {}: {}",
                                   WithoutSecrets(params.maps.front().string()),
                                   WithoutSecrets(params.maps[i].string()),
                                   problem));
    }
  }
  if (params.resolution) metadata.resolution = *params.resolution;
  metadata.program_version = CEILMAP_VERSION;
  metadata.provenance = common.command_line;
  for (std::size_t i = 0; i < maps.size(); ++i) {
    metadata.provenance += fmt::format(
        "\n{}: {}", WithoutSecrets(params.maps[i].string()), maps[i]->Metadata().provenance);
  }
  return metadata;
}

[[noreturn]] void Refuse(const mapping::MergeResult& merged, const MergeCommandOptions& params) {
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
            const MergeCommandOptions& params,
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

void RunMerge(const MergeCommandOptions& params,
              const CommonOptions& common,
              terminal::Summary& summary) {
  params.Resolve(common.Existing());
  std::vector<std::unique_ptr<store::MapReader>> maps;
  std::vector<const store::MapReader*> readers;
  for (const fs::path& file : params.maps) {
    maps.push_back(std::make_unique<store::MapReader>(file));
    readers.push_back(maps.back().get());
  }
  const store::MapMetadata metadata = Describe(maps, params, common);
  store::MapWriter writer(params.output, metadata);
  for (const auto& map : maps) map->CheckCurrent();
  mapping::MergeResult merged;
  {
    terminal::Progress progress("drawing", "tiles");
    merged = mapping::MergeMaps(readers, metadata, {}, writer, [&progress](int done, int total) {
      progress.Update(done, total);
    });
  }
  if (!merged.ok()) Refuse(merged, params);
  writer.Commit();
  summary.files = {params.output};
  summary.frames = static_cast<std::int64_t>(merged.graph.trajectory.size());
  summary.quality = {{"maps", maps.size()},
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
  auto params = std::make_shared<MergeCommandOptions>();
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
