#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/commands/commands.hpp"
#include "app/terminal/clock.hpp"
#include "app/terminal/progress.hpp"
#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "mapping/mosaic/map_builder.hpp"
#include "mapping/mosaic/mosaic_parts.hpp"
#include "mapping/store/map_file.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {
namespace {

struct MosaicOptions {
  fs::path map;
  std::string part;  // K/N; empty: all
  std::vector<fs::path> parts;
  fs::path output;

  void Check(files::Existing existing) const;
};

void MosaicOptions::Check(files::Existing existing) const {
  if (output.extension() != ".gpkg") {
    throw InputError(fmt::format("{}: the name must end in .gpkg", output.string()));
  }
  if (part.empty() && IsRemoteName(map.string())) {
    throw InputError(fmt::format("{}: is on a server; download it, or draw it by --part K/N",
                                 WithoutSecrets(map.string())));
  }
  files::CheckOutputFiles({output}, existing);
}

/// K and N of K/N.
std::pair<int, int> ParsePart(const std::string& text) {
  constexpr int kMaxParts = 100'000;
  const auto number = [](std::string_view digits) {
    int value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return error == std::errc() && end == digits.data() + digits.size() ? value : 0;
  };
  const std::size_t slash = std::min(text.find('/'), text.size());
  const int part = number(std::string_view(text).substr(0, slash));
  const int parts = slash < text.size() ? number(std::string_view(text).substr(slash + 1)) : 0;
  if (part < 1 || part > parts || parts > kMaxParts) {
    throw InputError(fmt::format(
        "--part {}: must be K/N, part K of N, with 1 <= K <= N <= {}; e.g. 2/4", text, kMaxParts));
  }
  return {part, parts};
}

mosaic::MosaicParts ReadParts(const mosaic::UndrawnMap& map, const std::vector<fs::path>& files) {
  std::vector<mosaic::MosaicParts::NamedPart> parts;
  parts.reserve(files.size());
  for (const fs::path& file : files) {
    parts.push_back({WithoutSecrets(file.string()),
                     std::make_unique<store::MapReader>(file, store::FileKind::kMosaicPart)});
  }
  return {map, std::move(parts)};
}

/// A part, from the map. @return the grid of the whole.
store::MosaicGrid DrawPart(const MosaicOptions& params,
                           const mosaic::UndrawnMap& map,
                           const mosaic::DrawingProgress& progress) {
  const auto [part, parts] = ParsePart(params.part);
  const mosaic::MosaicRenderer renderer = map.Renderer();
  store::MapWriter writer(params.output, map.MetadataOf(part, parts, renderer.Grid()));
  mosaic::WritePart(renderer, part, parts, writer, progress);
  writer.Commit();
  return renderer.Grid();
}

/// The map with its mosaic, drawn here or assembled. @return its grid.
store::MosaicGrid DrawWhole(const MosaicOptions& params,
                            const store::MapReader& reader,
                            const mosaic::UndrawnMap& map,
                            const mosaic::DrawingProgress& progress) {
  store::MosaicGrid grid;
  const auto write = [&](const auto& draw) {
    store::MapWriter writer(params.output, reader.Metadata(), params.map);
    reader.CheckCurrent();
    grid = draw(writer);
    writer.Commit();
  };
  if (params.parts.empty()) {
    write([&](store::MapWriter& writer) {
      return mosaic::WriteMosaic(map.Renderer(), writer, progress).grid;
    });
  } else {
    const mosaic::MosaicParts parts = ReadParts(map, params.parts);
    write([&](store::MapWriter& writer) {
      parts.WriteTo(writer, progress);
      return parts.Grid();
    });
  }
  return grid;
}

void RunMosaic(const MosaicOptions& params,
               const CommonOptions& common,
               terminal::Summary& summary) {
  params.Check(common.Existing());
  if (!params.part.empty()) static_cast<void>(ParsePart(params.part));
  const store::MapReader reader(params.map);
  const mosaic::UndrawnMap map(WithoutSecrets(params.map.string()), reader);
  const auto start = std::chrono::steady_clock::now();
  store::MosaicGrid grid;
  {
    terminal::Progress progress(params.parts.empty() ? "drawing" : "assembling", "tiles");
    const auto report = [&progress](int done, int total) { progress.Update(done, total); };
    grid = params.part.empty() ? DrawWhole(params, reader, map, report)
                               : DrawPart(params, map, report);
  }
  summary.stages_ms[params.parts.empty() ? "draw" : "assemble"] =
      1e3 * terminal::SecondsSince(start);
  summary.files = {params.output};
  summary.frames = static_cast<std::int64_t>(map.KeyframeCount());
  summary.quality = {
      {"width_px", grid.width_px}, {"height_px", grid.height_px}, {"resolution", grid.resolution}};
  if (common.quiet) return;
  fmt::print("{} {} x {} px\nwritten {}\n",
             params.part.empty() ? "mosaic of" : fmt::format("part {} of a mosaic of", params.part),
             grid.width_px,
             grid.height_px,
             params.output.string());
}

}  // namespace

Command AddMosaicCommand(CLI::App& program) {
  Command command = MakeCommand(
      program,
      "mosaic",
      "Draws the mosaic of a map of 'ceilmap solve --no-mosaic': at once, or in parts by several "
      "jobs, which are then assembled. The pixels are the same.",
      "ceilmap mosaic undrawn.gpkg --part 1/2 -o part-1.gpkg\n"
      "  ceilmap mosaic undrawn.gpkg --part 2/2 -o part-2.gpkg\n"
      "  ceilmap mosaic undrawn.gpkg --assemble part-1.gpkg part-2.gpkg -o site.gpkg");
  auto params = std::make_shared<MosaicOptions>();
  CLI::App& cli = *command.cli;
  cli.add_option("map", params->map, "The map without a mosaic")->required()->type_name("MAP.gpkg");
  CLI::Option* const part =
      cli.add_option("--part", params->part, "Draw only part K of N, a band of the mosaic")
          ->type_name("K/N");
  cli.add_option("--assemble", params->parts, "Make the mosaic of all its parts, in any order")
      ->excludes(part)
      ->type_name("PART.gpkg");
  cli.add_option("-o,--output", params->output, "The map with its mosaic, or the part")
      ->required()
      ->type_name("FILE.gpkg");
  command.run = [params](const CommonOptions& common, terminal::Summary& summary) {
    RunMosaic(*params, common, summary);
  };
  return command;
}

}  // namespace ceilmap::commands
