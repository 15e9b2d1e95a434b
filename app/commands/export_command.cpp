#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/commands/frame_option.hpp"
#include "app/commands/map_bag.hpp"
#include "app/files/output_files.hpp"
#include "app/files/tum.hpp"
#include "app/terminal/console.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "mapping/graph/g2o.hpp"
#include "mapping/mosaic/floor_heights.hpp"
#include "mapping/store/export.hpp"
#include "mapping/store/postgis.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct ExportOptions {
  fs::path map;
  std::string format;
  fs::path output;
  bool from_below = false;
  std::string name;  // with postgis
  fs::path mosaic;
  FrameOption frame;

  [[nodiscard]] bool ToDatabase() const { return format == "postgis"; }
  void Check() const;
};

void ExportOptions::Check() const {
  if (from_below && format != "png") {
    throw InputError(fmt::format(
        "--from-below is for --format png; --format {} is used with maps seen from above", format));
  }
  if (!ToDatabase() && !(name.empty() && mosaic.empty())) {
    throw InputError(fmt::format("{} is for --format postgis; leave it out",
                                 name.empty() ? "--mosaic" : "--name"));
  }
  if (!ToDatabase() && store::IsPostgisConnection(output.string())) {
    throw InputError("-o: is a database; give --format postgis, or a file");
  }
  if (ToDatabase() && !store::IsPostgisConnection(output.string())) {
    throw InputError(
        "--format postgis writes into a database; give -o 'PG:host=HOST dbname=NAME user=USER'");
  }
  const bool has_frame = format == "geotiff" || format == "cog" || format == "heights" ||
                         format == "ros" || format == "tum" || ToDatabase();
  if (frame.Value() == store::Frame::kSite && !has_frame) {
    throw InputError(fmt::format(
        "--frame site is for the formats geotiff, cog, heights, ros, tum and postgis; {} is in the "
        "map's coordinates",
        format));
  }
}

/// Heights at the pixels of the mosaic.
void ExportHeights(const store::MapReader& map, const fs::path& output, store::Frame frame) {
  const std::vector<graph::Keyframe> keyframes = map.ReadKeyframes();
  if (std::none_of(keyframes.begin(), keyframes.end(), [](const graph::Keyframe& keyframe) {
        return keyframe.heights != nullptr;
      })) {
    throw InputError("the map has no heights: its ceiling is one plane");
  }
  const mosaic::FloorHeights heights(keyframes, map.Metadata());
  if (heights.empty()) {
    throw InputError("the map's heights are not in metres; make the map again with a rig");
  }
  if (map.Grid().width_px == 0) {
    throw InputError("the map holds no mosaic, so there is no raster for its heights");
  }
  store::ExportHeights(
      map.Grid(),
      [&](const cv::Rect& window, cv::Mat& metres) { metres = heights.Window(map.Grid(), window); },
      output,
      store::SiteOf(map, frame));
}

// Of every recording of the map. Stamps may repeat if recordings were merged.
std::string TrajectoryText(const store::MapReader& map, store::Frame frame_of_result) {
  const survey::SiteFrame* site = store::SiteOf(map, frame_of_result);
  std::vector<StampedPose> poses;
  for (const graph::FramePose& frame : map.ReadTrajectory()) {
    if (!graph::HasPose(frame.status)) continue;
    const Pose2& T = frame.T_map_base;
    poses.push_back(
        ToStampedPose(frame.stamp_s, site != nullptr ? site->S_site_map * T : T, frame.tilt));
  }
  std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_s < b.stamp_s;
  });
  return files::FormatTum(poses);
}

void WriteBag(const store::MapReader& map, const fs::path& output, terminal::Summary& summary) {
  const store::MosaicGrid grid = ExportMapBag(map, output);
  summary.quality["grid_width"] = grid.width_px;
  summary.quality["grid_height"] = grid.height_px;
  if (grid.resolution == map.Grid().resolution) return;
  terminal::Note("/map has cells of {:.4g} m, because the mosaic's pixels of {:.4g} m are too many",
                 grid.resolution,
                 map.Grid().resolution);
}

void WriteDatabase(const store::MapReader& map,
                   const ExportOptions& params,
                   bool replace,
                   terminal::Summary& summary) {
  store::PostgisOptions options;
  options.name = params.name.empty() ? fs::path(WithoutSecrets(params.map.string())).stem().string()
                                     : params.name;
  options.replace = replace;
  options.frame = params.frame.Value();
  if (!params.mosaic.empty()) {
    options.mosaic = fs::absolute(params.mosaic).string();
    options.before_writing = [&] { store::ExportCog(map, params.mosaic, options.frame); };
  }
  store::ExportPostgis(map, params.output.string(), options);
  summary.quality["database"] = WithoutSecrets(params.output.string());
  summary.quality["name"] = options.name;
}

std::vector<fs::path> OutputFiles(const ExportOptions& params) {
  if (params.format == "postgis") {
    return params.mosaic.empty() ? std::vector<fs::path>() : std::vector<fs::path>{params.mosaic};
  }
  if (params.format != "ros") return {params.output};
  fs::path yaml = params.output;
  if (yaml.extension() != ".yaml") yaml += ".yaml";
  return {yaml, fs::path(yaml).replace_extension(".png")};
}

void RunExport(const ExportOptions& params,
               const CommonOptions& common,
               terminal::Summary& summary) {
  params.Check();
  const std::vector<fs::path> files = OutputFiles(params);
  files::CheckOutputFiles(files, common.Existing());
  const store::MapReader map(params.map);
  if (params.format == "png") {
    store::ExportPng(map, params.output, {.seen_from_below = params.from_below});
  } else if (params.format == "geotiff") {
    store::ExportGeoTiff(map, params.output, params.frame.Value());
  } else if (params.format == "cog") {
    store::ExportCog(map, params.output, params.frame.Value());
  } else if (params.ToDatabase()) {
    WriteDatabase(map, params, common.force, summary);
  } else if (params.format == "heights") {
    ExportHeights(map, params.output, params.frame.Value());
  } else if (params.format == "g2o") {
    files::WriteFileAtomically(params.output, graph::FormatG2o(map.ReadGraph()));
  } else if (params.format == "tum") {
    files::WriteFileAtomically(params.output, TrajectoryText(map, params.frame.Value()));
  } else if (params.format == "mcap") {
    WriteBag(map, params.output, summary);
  } else {
    store::ExportRos(map, params.output, params.frame.Value());
  }
  summary.files = files;
  summary.quality["map_width_px"] = map.Grid().width_px;
  summary.quality["map_height_px"] = map.Grid().height_px;
  if (common.quiet) return;
  for (const fs::path& file : files) fmt::print("written {}\n", file.string());
  if (params.ToDatabase()) fmt::print("written to {}\n", WithoutSecrets(params.output.string()));
}

}  // namespace

Command AddExportCommand(CLI::App& program) {
  Command command =
      MakeCommand(program,
                  "export",
                  "Converts a map for other programs: its mosaic for ROS map_server "
                  "and Nav2, GIS, web maps or people, the heights of its ceiling as a "
                  "GeoTIFF, its pose graph as g2o text, its trajectory as TUM "
                  "lines, its mosaic, keyframes and trajectory for ROS 2 and Foxglove "
                  "as an MCAP bag, its layers as tables of a PostGIS database.",
                  "ceilmap export lab.gpkg --format ros -o lab.yaml\n"
                  "  ceilmap export lab.gpkg --format mcap -o lab.mcap\n"
                  "  ceilmap export plant.gpkg --format heights -o plant.tif\n"
                  "  ceilmap export lab.gpkg --format cog -o lab.tif\n"
                  "  ceilmap export lab.gpkg --format postgis --mosaic lab.tif -o 'PG:host=db "
                  "dbname=site'");
  auto params = std::make_shared<ExportOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("map", params->map, "The map")->required()->type_name("MAP.gpkg");
  cli.add_option("--format", params->format, "Format of the result")
      ->required()
      ->check(CLI::IsMember(
          {"ros", "geotiff", "heights", "png", "g2o", "tum", "mcap", "cog", "postgis"}));
  cli.add_option("-o,--output",
                 params->output,
                 "Output file; with ros PATH.yaml and PATH.png; with postgis the database, "
                 "'PG:host=... dbname=...' (password: ~/.pgpass or PGPASSWORD)")
      ->required()
      ->type_name("PATH");
  cli.add_option("--name", params->name, "Name of the map in the database [that of its file]")
      ->type_name("NAME");
  cli.add_option(
         "--mosaic", params->mosaic, "With postgis: the mosaic as a cloud optimized GeoTIFF beside")
      ->type_name("FILE.tif");
  cli.add_flag("--from-below", params->from_below, "png as seen from below");
  params->frame.AddTo(cli);
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunExport(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
