#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "app/commands/commands.hpp"
#include "app/commands/size_budget.hpp"
#include "app/files/output_files.hpp"
#include "app/reports/history_report.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"
#include "mapping/change/map_pruning.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct PruneCommandOptions {
  fs::path map;
  fs::path output;
  std::string before;
  bool redundant = false;
  SizeBudget budget;

  [[nodiscard]] fs::path Result() const { return output.empty() ? map : output; }
  [[nodiscard]] change::PruneOptions Pruning() const;
};

change::PruneOptions PruneCommandOptions::Pruning() const {
  change::PruneOptions pruning;
  if (!before.empty()) pruning.before = before;
  pruning.redundant = redundant;
  pruning.max_bytes = budget.Bytes();
  if (!pruning.before && !redundant && !pruning.max_bytes) {
    throw InputError("give --before, --redundant or --size-budget: what is to be removed");
  }
  pruning.Validate();
  return pruning;
}

void RunPrune(const PruneCommandOptions& options,
              const CommonOptions& common,
              terminal::Summary& summary) {
  const change::PruneOptions pruning = options.Pruning();
  // Without --output the map itself is changed.
  files::CheckOutputFiles(
      {options.Result()}, common.Existing(), options.output.empty() ? options.map : fs::path());
  const change::PruneReport report =
      change::PruneMap(options.map, options.Result(), common.command_line, pruning);
  if (!report.keyframes.within_budget) {
    terminal::PrintWarning(
        fmt::format("{} has {:.1f} MB, more than the budget: no more keyframes can be spared",
                    options.Result().string(),
                    1e-6 * static_cast<double>(report.bytes_after)));
  }
  summary.files.push_back(options.Result());
  summary.quality["prune"] = reports::ToJson(report);
  if (common.quiet) return;
  terminal::Table facts = reports::FactsOf(report);
  fmt::print(
      "{}written {}\n", facts.Format(terminal::Table::Numbers::kLeft), options.Result().string());
}

}  // namespace

Command AddPruneCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "prune",
      "Removes from a map what nobody needs: old history, and keyframes that others cover. Poses, "
      "frame and mosaic stay.",
      "ceilmap prune hall.gpkg --redundant\n"
      "  ceilmap prune hall.gpkg --before 2026-11-01 --size-budget 20 -o small.gpkg");
  auto options = std::make_shared<PruneCommandOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("map", options->map, "The map")->required()->type_name("MAP.gpkg");
  cli.add_option("--before",
                 options->before,
                 "Remove sessions before this date (UTC), and changes that were replaced before")
      ->type_name("YYYY-MM-DD");
  cli.add_flag("--redundant",
               options->redundant,
               "Remove all keyframes of which two others show each place");
  options->budget.AddTo(
      cli,
      "Remove such keyframes until the file is not larger, the least agreeing and oldest first");
  cli.add_option("-o,--output", options->output, "The smaller map [the map itself]")
      ->type_name("NEW.gpkg");
  command.run = [options](const CommonOptions& common, terminal::Summary& summary) {
    RunPrune(*options, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
