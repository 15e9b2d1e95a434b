#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>

#include "mapping/store/map_file.hpp"

namespace ceilmap::store {

/// Export of the mosaic for other programs. Files are written under temporary names and renamed;
/// memory is bounded by windows for GeoTIFF, and by the size of the mosaic for the images.

struct PngOptions {
  bool seen_from_below = false;  ///< flipped left-right, as seen from below
};
void ExportPng(const MapReader& map,
               const std::filesystem::path& file,
               const PngOptions& options = {});

/// Tiled, compressed GeoTIFF with overviews and the map's local engineering SRS.
void ExportGeoTiff(const MapReader& map, const std::filesystem::path& file);

/// The same as a Cloud Optimized GeoTIFF, which programs read over the network by parts. Needs
/// twice the space while it is written.
void ExportCog(const MapReader& map, const std::filesystem::path& file);

/// Fills a window of a raster of heights: metres above the floor, CV_32FC1, NaN where not known.
using HeightSource = std::function<void(const cv::Rect& window, cv::Mat& metres)>;

/// GeoTIFF of one band `heights`, 32 bit numbers in metres above the floor, NaN for no data; tiled
/// and compressed, with the map's SRS.
/// @param grid  of the raster, usually the mosaic's: the two files then lie on each other pixel by
/// pixel.
void ExportHeights(const MosaicGrid& grid,
                   const HeightSource& source,
                   const std::filesystem::path& file);

/// `PATH.yaml` + `PATH.png` (PATH with or without .yaml) in the format of ROS map_server and Nav2:
/// image, resolution, origin [x, y, yaw] of the lower left pixel's corner, negate, thresholds,
/// mode.
/// @throws InputError for a map in pixels, which has no metres.
void ExportRos(const MapReader& map, const std::filesystem::path& path);

}  // namespace ceilmap::store
