#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "mapping/store/map_file.hpp"

namespace ceilmap::store {

/// The mosaic as other programs want it. Files are written aside and renamed; memory is bounded by
/// windows for GeoTIFF, by the mosaic's size for the images.

struct PngOptions {
  bool seen_from_below = false;  ///< flipped left-right, as a person who looks up sees the ceiling
};
void ExportPng(const MapReader& map,
               const std::filesystem::path& file,
               const PngOptions& options = {});

/// Tiled, compressed GeoTIFF with overviews and the map's local engineering SRS.
void ExportGeoTiff(const MapReader& map, const std::filesystem::path& file);

/// `PATH.yaml` + `PATH.png` (PATH may be given with or without .yaml) as ROS map_server and Nav2
/// read them: image, resolution, origin [x, y, yaw] of the lower left pixel's corner, negate,
/// thresholds, mode.
/// @throws InputError for a map in pixels, which has no metres.
void ExportRos(const MapReader& map, const std::filesystem::path& path);

}  // namespace ceilmap::store
