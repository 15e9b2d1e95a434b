#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

namespace ceilmap::store {

/// A floor plan in the coordinates of its building: an image, or lines.
struct SitePlan {
  cv::Mat image;  ///< CV_8UC3, blue first; empty for a drawing
  /// From pixels, counted from the corner of the first one: x = t[0] + t[1] col + t[2] row,
  /// y = t[3] + t[4] col + t[5] row.
  std::array<double, 6> transform{};
  std::vector<std::vector<Eigen::Vector2d>> lines;  ///< of a drawing
};

/// Reads a GeoTIFF, a PNG or JPEG image with a world file beside it, a DXF drawing or GeoJSON.
/// Large images are reduced to 4096 pixels a side. The coordinate system is not converted: the plan
/// must have that of the control points.
/// @throws InputError when the file cannot be read, an image has no position, or a drawing has no
/// lines or more than a million vertices.
SitePlan ReadSitePlan(const std::filesystem::path& file);

}  // namespace ceilmap::store
