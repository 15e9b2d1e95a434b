#pragma once

#include <filesystem>

#include "mapping/store/map_file.hpp"

namespace ceilmap::commands {

/// Writes a map as an MCAP file for ROS 2 and Foxglove: the mosaic as nav_msgs/OccupancyGrid on
/// /map and the keyframes as nav_msgs/Path on /keyframes, both latched (durability transient
/// local), and the trajectory of every recording of the map (files::TrajectoryBag).
///
/// A cell is 0 where the mosaic is white, 100 where it is black, -1 where nothing was mapped. Of a
/// large mosaic each cell is the mean of 2 x 2, 4 x 4, ... pixels, so that no side has more than
/// 4096 cells.
/// @return the extent and the resolution of the grid.
/// @throws InputError for a map in pixels or without a mosaic, or with a time that ROS cannot
///   express; RunError when the disk cannot be written.
store::MosaicGrid ExportMapBag(const store::MapReader& map, const std::filesystem::path& file);

}  // namespace ceilmap::commands
