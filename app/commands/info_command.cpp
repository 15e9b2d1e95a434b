#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <opencv2/core.hpp>
#include <vector>

#include "app/bags/bag_reader.hpp"
#include "app/commands/commands.hpp"
#include "app/files/output_files.hpp"
#include "app/recordings/rig_warnings.hpp"
#include "app/reports/alignment_report.hpp"
#include "app/reports/bag_report.hpp"
#include "app/reports/height_summary.hpp"
#include "app/reports/history_report.hpp"
#include "app/reports/map_quality.hpp"
#include "app/reports/rig_drawing.hpp"
#include "app/reports/rig_report.hpp"
#include "app/terminal/console.hpp"
#include "app/terminal/table.hpp"
#include "calib/base/degrees.hpp"
#include "calib/base/error.hpp"
#include "calib/base/one_line.hpp"
#include "mapping/store/map_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

using nlohmann::ordered_json;

struct InfoOptions {
  fs::path file;
  fs::path drawing;
  bool json = false;
  bool changes = false;
};

// Metadata of a map, and counts of its content.
struct MapInfo {
  store::MapMetadata metadata;
  store::MosaicGrid grid;
  std::size_t keyframes = 0;
  reports::HeightSummary heights;
  std::size_t poses = 0;
  std::size_t edges = 0;
  double first_stamp_s = 0;
  double last_stamp_s = 0;
  double covered_area = 0;  // unit^2
  std::uintmax_t file_bytes = 0;
  graph::MapQuality quality;
  std::vector<graph::WeakSpot> weak_spots;
  std::vector<store::LeftOut> left_out;
};

// Processed by windows, because a map can be larger than memory.
double CoveredArea(const store::MapReader& map) {
  constexpr int kWindow = 2048;
  const store::MosaicGrid& grid = map.Grid();
  std::int64_t covered_px = 0;
  cv::Mat grey;
  cv::Mat alpha;
  for (int row = 0; row < grid.height_px; row += kWindow) {
    for (int col = 0; col < grid.width_px; col += kWindow) {
      const cv::Rect window(col,
                            row,
                            std::min(kWindow, grid.width_px - col),
                            std::min(kWindow, grid.height_px - row));
      map.ReadMosaic(window, grey, alpha);
      covered_px += cv::countNonZero(alpha);
    }
  }
  return static_cast<double>(covered_px) * grid.resolution * grid.resolution;
}

MapInfo Inspect(const fs::path& file) {
  const store::MapReader map(file);
  MapInfo info;
  info.metadata = map.Metadata();
  info.grid = map.Grid();
  const std::vector<graph::Keyframe> keyframes = map.ReadKeyframes();
  info.keyframes = keyframes.size();
  info.heights = reports::SummarizeHeights(keyframes, info.metadata);
  info.edges = map.ReadEdges().size();
  const std::vector<graph::FramePose> trajectory = map.ReadTrajectory();
  info.poses = trajectory.size();
  if (!trajectory.empty()) {
    info.first_stamp_s = trajectory.front().stamp_s;
    info.last_stamp_s = trajectory.back().stamp_s;
  }
  info.covered_area = CoveredArea(map);
  info.file_bytes = map.FileBytes();
  info.quality = map.Quality();
  info.weak_spots = map.ReadWeakSpots();
  info.left_out = map.ReadLeftOut();
  return info;
}

ordered_json ToJson(const MapInfo& info) {
  const store::MapMetadata& metadata = info.metadata;
  const store::MosaicGrid& grid = info.grid;
  return {
      {"format_version", metadata.format_version},
      {"unit", metadata.unit},
      {"resolution", metadata.resolution},
      {"ceiling_height_m", metadata.ceiling_height_m},
      {"site", metadata.site ? reports::ToJson(*metadata.site) : nullptr},
      {"robot", metadata.robot},
      {"view",
       {{"width_px", metadata.view_size.width},
        {"height_px", metadata.view_size.height},
        {"units_per_px", metadata.view_units_per_px},
        {"T_base_view",
         {{"x", metadata.T_base_view.x},
          {"y", metadata.T_base_view.y},
          {"yaw_deg", metadata.T_base_view.yaw * kDegPerRad}}}}},
      {"grid",
       {{"min_x", grid.min_x},
        {"max_y", grid.max_y},
        {"resolution", grid.resolution},
        {"width_px", grid.width_px},
        {"height_px", grid.height_px}}},
      {"covered_area", info.covered_area},
      {"left_out", reports::ToJson(info.left_out)},
      {"keyframes", info.keyframes},
      {"heights", reports::ToJson(info.heights)},
      {"trajectory_poses", info.poses},
      {"first_stamp_s", info.first_stamp_s},
      {"last_stamp_s", info.last_stamp_s},
      {"edges", info.edges},
      {"quality", reports::ToJson(info.quality)},
      {"weak_spots", reports::ToJson(info.weak_spots)},
      {"file_bytes", info.file_bytes},
      {"program_version", metadata.program_version},
      {"provenance", metadata.provenance},
      {"rig_yaml", metadata.rig_yaml},
  };
}

void PrintTable(const MapInfo& info) {
  const store::MapMetadata& metadata = info.metadata;
  const store::MosaicGrid& grid = info.grid;
  const std::string& unit = metadata.unit;
  const double width = grid.width_px * grid.resolution;
  const double height = grid.height_px * grid.resolution;
  terminal::Table table;
  table.AddRow({"map size", fmt::format("{:.3f} x {:.3f} {}", width, height, unit)});
  table.AddRow({"map pixels", fmt::format("{} x {}", grid.width_px, grid.height_px)});
  table.AddRow({"resolution", fmt::format("{:.6g} {} per px", grid.resolution, unit)});
  table.AddRow(
      {"x from, to", fmt::format("{:.3f}, {:.3f} {}", grid.min_x, grid.min_x + width, unit)});
  table.AddRow(
      {"y from, to", fmt::format("{:.3f}, {:.3f} {}", grid.max_y - height, grid.max_y, unit)});
  table.AddRow({"area seen", fmt::format("{:.3f} {}^2", info.covered_area, unit)});
  table.AddRow({"left out", reports::Describe(info.left_out, unit)});
  table.AddRow({"keyframes", fmt::format("{}", info.keyframes)});
  table.AddRow({"heights", reports::Describe(info.heights)});
  table.AddRow({"trajectory", fmt::format("{} poses", info.poses)});
  table.AddRow({"time", fmt::format("{:.3f} .. {:.3f} s", info.first_stamp_s, info.last_stamp_s)});
  table.AddRow({"edges", fmt::format("{}", info.edges)});
  constexpr int kMaxSpots = 8;
  reports::AddQuality(info.quality, info.weak_spots, unit, kMaxSpots, table);
  table.AddRow({"images",
                fmt::format("{} x {} px, {:.6g} {} per px",
                            metadata.view_size.width,
                            metadata.view_size.height,
                            metadata.view_units_per_px,
                            unit)});
  table.AddRow({"ceiling", fmt::format("{:.3f} m above the floor", metadata.ceiling_height_m)});
  if (metadata.site) reports::AddSite(*metadata.site, table);
  table.AddRow({"robot", metadata.robot.empty() ? "not named" : InOneLine(metadata.robot)});
  table.AddRow({"rig", metadata.rig_yaml.empty() ? "none" : "stored; --json shows it"});
  table.AddRow({"file", fmt::format("{:.2f} MB", static_cast<double>(info.file_bytes) * 1e-6)});
  table.AddRow({"format", fmt::format("version {}", metadata.format_version)});
  table.AddRow({"made by", "ceilmap " + InOneLine(metadata.program_version)});
  table.AddRow({"provenance", InOneLine(metadata.provenance)});
  // All values are left-aligned: with units, right alignment has no use.
  fmt::print("{}", table.Format(terminal::Table::Numbers::kLeft));
}

/// What has happened to a map since it was made.
void ReportChanges(const InfoOptions& params) {
  const store::MapHistory history = store::MapReader(params.file).ReadHistory();
  if (params.json) {
    using Handler = ordered_json::error_handler_t;
    fmt::print("{}\n", reports::ToJson(history).dump(2, ' ', false, Handler::replace));
    return;
  }
  if (history.sessions.empty()) {
    fmt::print("never updated; 'ceilmap update' compares a recording with the map\n");
    return;
  }
  fmt::print("{}", reports::FormatPlain(reports::SessionsTable(history)));
  if (history.changes.empty()) return;
  fmt::print("\n{}", reports::FormatPlain(reports::ChangesTable(history.changes)));
}

void ReportMap(const InfoOptions& params, terminal::Summary& summary) {
  if (!params.drawing.empty()) {
    throw InputError(
        "--svg: is the drawing of a rig; give RIG.yaml, or 'export' a map as a picture");
  }
  if (params.changes) {
    ReportChanges(params);
    return;
  }
  const MapInfo info = Inspect(params.file);
  summary.frames = static_cast<std::int64_t>(info.poses);
  summary.quality = {{"keyframes", info.keyframes}, {"covered_area", info.covered_area}};
  if (params.json) {
    fmt::print("{}\n", ToJson(info).dump(2, ' ', false, ordered_json::error_handler_t::replace));
  } else {
    PrintTable(info);
  }
}

void ReportRig(const InfoOptions& params, const CommonOptions& common, terminal::Summary& summary) {
  if (!params.drawing.empty()) files::CheckOutputFiles({params.drawing}, common.Existing());
  const calib::Rig rig = calib::ReadRig(params.file);
  recordings::PrintRigWarnings(rig);
  if (params.json) {
    using Handler = ordered_json::error_handler_t;
    fmt::print("{}\n", reports::RigJson(rig).dump(2, ' ', false, Handler::replace));
  } else {
    fmt::print("{}", reports::DescribeRig(rig).Format(terminal::Table::Numbers::kLeft));
  }
  if (params.drawing.empty()) return;
  files::WriteFileAtomically(params.drawing, reports::DrawRig(rig));
  summary.files.push_back(params.drawing);
  if (!params.json && !common.quiet) fmt::print("written {}\n", params.drawing.string());
}

void ReportBag(const InfoOptions& params, terminal::Summary& summary) {
  if (!params.drawing.empty()) {
    throw InputError("--svg: is the drawing of a rig; give RIG.yaml");
  }
  const reports::BagContent content = reports::InspectBag(params.file);
  summary.frames = content.messages;
  for (const std::string& warning : content.warnings) terminal::PrintWarning(warning);
  if (params.json) {
    using Handler = ordered_json::error_handler_t;
    fmt::print("{}\n", reports::ToJson(content).dump(2, ' ', false, Handler::replace));
    return;
  }
  fmt::print("{}\n{}",
             reports::FactsOf(content).Format(terminal::Table::Numbers::kLeft),
             reports::TopicsOf(content).Format());
}

void RunInfo(const InfoOptions& params, const CommonOptions& common, terminal::Summary& summary) {
  const fs::path extension = params.file.extension();
  if (extension == ".yaml" || extension == ".yml") {
    ReportRig(params, common, summary);
  } else if (bags::BagReader::IsBag(params.file)) {
    ReportBag(params, summary);
  } else {
    ReportMap(params, summary);
  }
}

}  // namespace

Command AddInfoCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "info",
      "Reports the content and quality of a map (size, coverage, heights, loops, weak spots), "
      "what a rig means (what its cameras see, and how they are mounted), or the topics of a bag.",
      "ceilmap info lab.gpkg --json\n"
      "  ceilmap info run.mcap\n"
      "  ceilmap info rig.yaml --svg rig.svg");
  auto params = std::make_shared<InfoOptions>();
  command.cli->add_option("file", params->file, "The map, the rig or the bag")
      ->required()
      ->type_name("MAP.gpkg|RIG.yaml|BAG");
  command.cli->add_flag("--json", params->json, "One JSON object instead of a table");
  command.cli->add_flag("--changes",
                        params->changes,
                        "Of a map: its sessions, and what has changed ('ceilmap update')");
  command.cli
      ->add_option("--svg", params->drawing, "Drawing of the rig: axes, cameras, what they see")
      ->type_name("FILE.svg");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunInfo(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
