#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "app/commands/commands.hpp"
#include "app/commands/map_inputs.hpp"
#include "calib/base/error.hpp"
#include "mapping/edges_file.hpp"
#include "mapping/map_match.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct MatchOptions {
  fs::path a;
  fs::path b;
  fs::path output;
};

void RunMatch(const MatchOptions& params, const CommonOptions& common, terminal::Summary& summary) {
  files::CheckOutputFiles({params.output}, common.Existing());
  const MapInputs inputs({params.a, params.b});
  const mapping::MapMatch match = mapping::MatchMaps(inputs.Maps()[0], inputs.Maps()[1]);
  files::WriteFileAtomically(params.output, mapping::FormatEdges(match));
  const mapping::JoinResult& result = match.result;
  summary.files = {params.output};
  summary.frames = result.compared;
  summary.quality = {{"verdict", mapping::ToString(result.verdict)},
                     {"reason", result.reason},
                     {"compared", result.compared},
                     {"expected", result.expected},
                     {"matched", result.matched},
                     {"edges", result.edges.size()}};
  if (common.quiet) return;
  fmt::print("{} and {}: {}\n",
             params.a.string(),
             params.b.string(),
             result.ok() ? fmt::format("joined, {} of {} images agree where they must, {} edges",
                                       result.matched,
                                       result.expected,
                                       result.edges.size())
                         : "not joined: " + result.reason);
}

}  // namespace

Command AddMatchCommand(CLI::App& program) {
  Command command = MakeCommand(program,
                                "match",
                                "Measures the relative pose of two maps, for 'ceilmap solve'.",
                                "ceilmap match east.gpkg west.gpkg -o east-west.edges");
  auto params = std::make_shared<MatchOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("a", params->a, "A map")->required()->type_name("A.gpkg");
  cli.add_option("b", params->b, "Another map; cameras may differ in size, height and lens")
      ->required()
      ->type_name("B.gpkg");
  cli.add_option("-o,--output",
                 params->output,
                 "Relative pose and edges, or why there are none (exit code 0 as well)")
      ->required()
      ->type_name("AB.edges");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunMatch(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
