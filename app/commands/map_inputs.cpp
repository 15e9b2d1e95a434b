#include "app/commands/map_inputs.hpp"

#include <fmt/format.h>

#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"

namespace fs = std::filesystem;

namespace ceilmap::commands {

void UnionOptions::Resolve(const char* command, files::Existing existing, std::size_t least) const {
  if (maps.size() < least) throw InputError(fmt::format("{}: give at least two maps", command));
  if (output.extension() != ".gpkg") {
    throw InputError(fmt::format("{}: the map's name must end in .gpkg", output.string()));
  }
  if (resolution && !(*resolution > 0 && *resolution < 1e6)) {
    throw InputError(
        fmt::format("--resolution {}: must be > 0, metres per pixel of the map", *resolution));
  }
  files::CheckOutputFiles({output}, existing);
}

MapInputs::MapInputs(const std::vector<fs::path>& files) {
  for (const fs::path& file : files) {
    readers_.push_back(std::make_unique<store::MapReader>(file));
    maps_.push_back({readers_.back().get(), WithoutSecrets(file.string())});
  }
}

void MapInputs::CheckCurrent() const {
  for (const auto& reader : readers_) reader->CheckCurrent();
}

store::MapMetadata DescribeUnion(const std::vector<mapping::NamedMap>& maps,
                                 const mapping::CommonView& view,
                                 const std::optional<double>& resolution,
                                 const CommonOptions& common) {
  store::MapMetadata metadata = view.Metadata();
  if (resolution) metadata.resolution = *resolution;
  metadata.program_version = CEILMAP_VERSION;
  metadata.provenance = common.command_line;
  for (const mapping::NamedMap& named : maps) {
    metadata.provenance += fmt::format("\n{}: {}", named.name, named.map->Metadata().provenance);
  }
  return metadata;
}

}  // namespace ceilmap::commands
