#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "mapping/store/map_file.hpp"
#include "mapping/survey/alignment.hpp"

namespace ceilmap::commands {

/// Control points of a map: --points, --crs, --sigma.
struct PointOptions {
  std::filesystem::path points;
  std::string crs;
  survey::AlignOptions params;

  /// @return --points, for further settings.
  CLI::Option* AddTo(CLI::App& cli);
  /// @throws InputError for values out of range, and --crs or --sigma without --points.
  void Check() const;
  /// The points in the map. @param grid  of the mosaic on which they were picked.
  /// @throws InputError naming the file.
  [[nodiscard]] std::vector<survey::ControlPoint> Read(const store::MosaicGrid& grid) const;
  /// --crs as WKT, empty without it. @throws InputError
  [[nodiscard]] std::string CrsWkt() const;
};

}  // namespace ceilmap::commands
