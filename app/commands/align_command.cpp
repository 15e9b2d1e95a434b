#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <optional>

#include "app/commands/commands.hpp"
#include "app/commands/point_options.hpp"
#include "app/files/output_files.hpp"
#include "app/reports/alignment_drawing.hpp"
#include "app/reports/alignment_report.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"
#include "mapping/store/map_file.hpp"
#include "mapping/store/map_revision.hpp"
#include "mapping/store/site_plan.hpp"
#include "mapping/survey/alignment.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct AlignOptions {
  fs::path map;
  PointOptions points;
  fs::path plan;
  fs::path picture;
  fs::path output;

  [[nodiscard]] fs::path Result() const { return output.empty() ? map : output; }
  void Check(files::Existing existing) const;
};

void AlignOptions::Check(files::Existing existing) const {
  if (Result().extension() != ".gpkg") {
    throw InputError(fmt::format("{}: the map's name must end in .gpkg", Result().string()));
  }
  if (!plan.empty() && picture.empty()) {
    throw InputError("--plan: is drawn under the mosaic; give --picture FILE.svg too");
  }
  points.Check();
  // Without --output the map itself is changed.
  files::CheckOutputFiles({Result(), picture}, existing, output.empty() ? map : fs::path());
}

survey::Alignment AlignMap(const AlignOptions& options, const store::MapReader& map) {
  survey::AlignOptions params = options.points.params;
  // A map in pixels has no scale of its own.
  params.estimate_scale = params.estimate_scale || map.Metadata().unit == "px";
  const std::vector<survey::ControlPoint> points = options.points.Read(map.Grid());
  try {
    return survey::Align(points, params);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", options.points.points.string(), error.what()));
  }
}

void PrintAlignment(const survey::Alignment& alignment, const terminal::Summary& summary) {
  terminal::Table facts;
  facts.AddRow(
      {"points used", fmt::format("{} of {}", alignment.used, alignment.site.points.size())});
  facts.AddRow({"residuals", fmt::format("{:.1f} mm RMS", 1e3 * alignment.rms_m)});
  if (alignment.used > 2) {
    facts.AddRow(
        {"leave-one-out error", fmt::format("{:.1f} mm RMS", 1e3 * alignment.leave_one_out_rms_m)});
  }
  reports::AddSite(alignment.site, facts);
  fmt::print("{}\n{}",
             reports::FormatPlain(reports::PointsTable(alignment.site)),
             facts.Format(terminal::Table::Numbers::kLeft));
  for (const fs::path& file : summary.files) fmt::print("written {}\n", file.string());
}

void RunAlign(const AlignOptions& options,
              const CommonOptions& common,
              terminal::Summary& summary) {
  options.Check(common.Existing());
  const store::MapReader map(options.map);
  std::optional<store::SitePlan> plan;
  if (!options.plan.empty()) plan = store::ReadSitePlan(options.plan);
  survey::Alignment alignment = AlignMap(options, map);
  alignment.site.crs_wkt = options.points.CrsWkt();
  if (!options.picture.empty()) {
    files::WriteFileAtomically(options.picture, reports::DrawAlignment(map, alignment.site, plan));
    summary.files.push_back(options.picture);
  }
  store::MapRevision revision(options.map, options.Result(), common.command_line);
  revision.SetSiteFrame(alignment.site);
  revision.Commit();
  summary.files.insert(summary.files.begin(), options.Result());
  summary.quality = {{"points", alignment.site.points.size()},
                     {"used", alignment.used},
                     {"rms_m", alignment.rms_m},
                     {"leave_one_out_rms_m", alignment.leave_one_out_rms_m},
                     {"sigma_ratio", alignment.sigma_ratio},
                     {"site", reports::ToJson(alignment.site)}};
  for (const std::string& warning : reports::WarningsOf(alignment, map.Metadata().unit)) {
    terminal::PrintWarning(warning);
  }
  if (!common.quiet) PrintAlignment(alignment, summary);
}

}  // namespace

Command AddAlignCommand(CLI::App& program) {
  Command command =
      MakeCommand(program,
                  "align",
                  "Places a map in the coordinates of its building by surveyed points, so that "
                  "poses and exports can be had in them (--frame site).",
                  "ceilmap align lab.gpkg --points points.csv --picture aligned.svg\n"
                  "  ceilmap align lab.gpkg --points points.csv --crs EPSG:25832 -o site.gpkg");
  auto options = std::make_shared<AlignOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("map", options->map, "The map; it is changed, unless --output is given")
      ->required()
      ->type_name("MAP.gpkg");
  options->points.AddTo(cli)->required();
  cli.add_flag("--scale",
               options->points.params.estimate_scale,
               "Estimate the scale of the map too; always done for a map in pixels");
  cli.add_option("--plan",
                 options->plan,
                 "Floor plan in the building's coordinates, for the picture: GeoTIFF, PNG or JPEG "
                 "with a world file, DXF, GeoJSON")
      ->type_name("FILE");
  cli.add_option(
         "--picture", options->picture, "Drawing of the mosaic, the points and their residuals")
      ->type_name("FILE.svg");
  cli.add_option("-o,--output", options->output, "The aligned map [the map itself]")
      ->type_name("OUT.gpkg");
  command.run = [options](const CommonOptions& common, terminal::Summary& summary) {
    RunAlign(*options, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
