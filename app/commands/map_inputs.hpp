#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "app/commands/commands.hpp"
#include "mapping/common_view.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::commands {

/// The options of commands that make one map of several.
struct UnionOptions {
  std::vector<std::filesystem::path> maps;
  std::optional<double> resolution;  ///< map units per pixel; unset: as the first map has it
  std::filesystem::path output;

  /// @param command  its name, for the message. @param least  number of maps. @throws InputError
  void Resolve(const char* command, files::Existing existing, std::size_t least = 2) const;
};

/// Maps that are read.
class MapInputs {
 public:
  /// @throws InputError as store::MapReader.
  explicit MapInputs(const std::vector<std::filesystem::path>& files);

  [[nodiscard]] const std::vector<mapping::NamedMap>& Maps() const { return maps_; }
  /// To be called once a writer holds the name of the output.
  /// @throws InputError when a map has been replaced since it was opened.
  void CheckCurrent() const;

 private:
  std::vector<std::unique_ptr<store::MapReader>> readers_;
  std::vector<mapping::NamedMap> maps_;
};

/// Metadata of the union of maps with a common view; the provenance has the command and that of
/// each map.
store::MapMetadata DescribeUnion(const std::vector<mapping::NamedMap>& maps,
                                 const mapping::CommonView& view,
                                 const std::optional<double>& resolution,
                                 const CommonOptions& common);

}  // namespace ceilmap::commands
