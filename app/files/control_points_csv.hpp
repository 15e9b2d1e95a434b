#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mapping/survey/site_frame.hpp"

namespace ceilmap::files {

/// Control points as they were picked.
struct PickedPoints {
  std::vector<survey::ControlPoint> points;  ///< sigma_m 0 where the file states none
  /// True: p_map holds pixels (column, row) of the map's mosaic, whose first pixel has its centre
  /// at (0, 0); false: map units.
  bool in_pixels = false;
};

/// Reads `name,x,y,site_x,site_y[,sigma_m]`, places in the map, or
/// `name,col,row,site_x,site_y[,sigma_m]`, pixels of the mosaic as `export --format png` and
/// `geotiff` write it.
/// @return at least one point. @throws InputError naming file and line.
PickedPoints ReadControlPoints(const std::filesystem::path& file);

/// The same from the text of a file. @param name  Its name in messages.
PickedPoints ParseControlPoints(const std::string& text, const std::string& name);

}  // namespace ceilmap::files
