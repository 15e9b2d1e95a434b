#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "app/commands/commands.hpp"
#include "app/commands/map_inputs.hpp"
#include "app/page/page.hpp"
#include "app/reports/difference_report.hpp"
#include "app/reports/report_folder.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct DiffOptions {
  fs::path before;
  fs::path after;
  fs::path output;
  fs::path report;
};

void RunDiff(const DiffOptions& options, const CommonOptions& common, terminal::Summary& summary) {
  files::CheckOutputFiles({options.output}, common.Existing());
  if (!options.report.empty()) files::CheckOutputFolder(options.report, common.Existing());
  const MapInputs inputs({options.before, options.after});
  reports::ComparedMaps compared{inputs.Maps()[0], inputs.Maps()[1], {}, {}};
  compared.placed = mapping::PlacedOn(compared.before, compared.after);
  compared.difference =
      change::CompareMaps(*compared.before.map, *compared.after.map, compared.placed.keyframes);
  if (!options.output.empty()) {
    files::WriteFileAtomically(options.output, reports::DifferenceCsv(compared.difference));
    summary.files.push_back(options.output);
  }
  if (!options.report.empty()) {
    const auto written = reports::WriteReport(
        options.report, {{"index.html", page::WritePage(reports::DifferencePage(compared))}});
    summary.files.insert(summary.files.end(), written.begin(), written.end());
  }
  summary.quality["difference"] = reports::ToJson(compared);
  if (common.quiet) return;
  fmt::print("{}", reports::FactsOf(compared).Format(terminal::Table::Numbers::kLeft));
  const std::string unit = compared.before.map->Metadata().unit;
  const reports::ReportTable changes = reports::DifferenceTable(compared.difference, unit);
  if (!changes.rows.empty()) fmt::print("\n{}", reports::FormatPlain(changes));
  for (const fs::path& file : summary.files) fmt::print("written {}\n", file.string());
}

}  // namespace

Command AddDiffCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "diff",
      "Lists what differs between two maps of one ceiling: a map and its update, or maps of two "
      "recordings.",
      "ceilmap diff monday.gpkg friday.gpkg -o changes.csv --report changes");
  auto options = std::make_shared<DiffOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("before", options->before, "The earlier map, with a mosaic")
      ->required()
      ->type_name("BEFORE.gpkg");
  cli.add_option(
         "after",
         options->after,
         "The later map, with a mosaic; an update of the earlier one, or of another recording")
      ->required()
      ->type_name("AFTER.gpkg");
  cli.add_option("-o,--output",
                 options->output,
                 "The changes, with outlines (WKT) in the frame of the earlier map")
      ->type_name("CHANGES.csv");
  cli.add_option("--report",
                 options->report,
                 "Folder for a page (index.html) with both mosaics and a divider between them")
      ->type_name("DIR");
  command.run = [options](const CommonOptions& common, terminal::Summary& summary) {
    RunDiff(*options, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
