#include <fmt/format.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "app/commands/compass_commands.hpp"
#include "app/files/output_files.hpp"
#include "app/reports/compass_report.hpp"
#include "calib/base/error.hpp"
#include "localization/compass/colour/colour_model_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct CompassMergeOptions {
  std::vector<fs::path> models;
  fs::path output;
};

colour::ColourModel MergeAll(const std::vector<fs::path>& files) {
  colour::ColourModel merged = colour::ReadColourModel(files.front());
  for (std::size_t i = 1; i < files.size(); ++i) {
    const colour::ColourModel other = colour::ReadColourModel(files[i]);
    try {
      colour::Merge(other, merged);
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("{} and {}: {}", files.front().string(), files[i].string(), error.what()));
    }
  }
  return merged;
}

void RunMerge(const CompassMergeOptions& params,
              const CommonOptions& common,
              terminal::Summary& summary) {
  if (params.models.size() < 2) throw InputError("compass merge: give at least two models");
  files::CheckOutputFiles({params.output}, common.Existing());
  colour::ColourModel model = MergeAll(params.models);
  model.provenance += (model.provenance.empty() ? "" : "\n") + common.command_line;
  colour::WriteColourModel(model, params.output);
  summary.files = {params.output};
  summary.frames = model.frames;
  summary.quality = {{"models", params.models.size()}, {"model", reports::ModelJson(model)}};
  if (common.quiet) return;
  terminal::Table table;
  table.AddRow({"models", fmt::format("{}", params.models.size())});
  table.AddRow({"frames", fmt::format("{}", model.frames), "learned from"});
  reports::AddModelRows(model, table);
  fmt::print("{}written {}\n", table.Format(), params.output.string());
}

}  // namespace

Command AddCompassMergeCommand(CLI::App& compass) {
  Command command =
      MakeCommand(compass,
                  "merge",
                  "Merges models that robots have updated from the same model.",
                  "ceilmap compass merge one.colours two.colours -o both.colours\n"
                  "The models must have the same classes, grid and directions: learn one model, "
                  "copy it to each robot, and update it there.");
  auto params = std::make_shared<CompassMergeOptions>();
  command.cli->add_option("models", params->models, "The models")->required()->type_name("MODEL");
  command.cli
      ->add_option("-o,--output", params->output, "The merged model; may be one of the inputs")
      ->required()
      ->type_name("MODEL");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunMerge(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
