#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/base/tilt.hpp"
#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::calib {

/// The quantity in which the rows of a panorama are equidistant.
enum class PanoramaRows : std::uint8_t {
  kRadius,        ///< from the centre of the mirror's image
  kPixelRadius,   ///< the same with one row per pixel of radius, as in Labrosse's unwrapping
  kElevation,     ///< angle above the horizon
  kTanElevation,  ///< its tangent: vertical objects keep their proportions, as on a cylinder
};

enum class Interpolation : std::uint8_t {
  kNearest,   ///< Labrosse's "not smooth"
  kBilinear,  ///< "smooth"
};

struct MirrorViewParams {
  int columns = 1080;  ///< 8 .. 16384, over the full circle
  int rows = 45;       ///< 1 .. 4096; not used with kPixelRadius
  Interpolation interpolation = Interpolation::kBilinear;
  /// Nothing: elevation for a mirror of known shape, so that the horizon is one row; radius for a
  /// ring, of which nothing else is known.
  std::optional<PanoramaRows> row_spacing = std::nullopt;
  /// Upper and lower edge of the panorama, in (-pi/2, pi/2), rad above the horizon; only for a
  /// mirror of known shape. Default of the upper edge: the highest elevation that the mirror shows.
  /// Default of the lower edge: as far below the horizon as the upper edge is above it, but between
  /// 15 and 30 deg, which excludes the robot and the floor around it.
  std::optional<double> highest_elevation_rad = std::nullopt;
  std::optional<double> lowest_elevation_rad = std::nullopt;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// The model of the camera under a convex mirror that all other libraries use: a panorama, sampled
/// from the mirror's image along a scan line that rotates about its centre (Labrosse 2004).
///
/// Column u of W shows azimuth pi - 2 pi u / W, counter-clockwise from the x axis of base: the
/// front of the robot is column W/2, its left W/4. The image is not mirrored: it shows the room as
/// seen by an observer who faces forward, with the top row highest. When the robot turns left by w,
/// the content moves to the RIGHT by w W / (2 pi) columns. Rows are of equal height; the centre of
/// row v lies at the fraction (v + 1/2) / rows of the distance from the upper edge (outer circle)
/// to the lower one.
///
/// For a camera that is mounted rotated about z, azimuth 0 remains at the front of the robot. A
/// common tilt of camera and mirror is removed when the shape of the mirror is known. A mirror that
/// is displaced from the axis of its camera, or tilted relative to it, is not modelled.
class MirrorView {
 public:
  /// @param omni  with `mirror` or `mirror_ring`; its optical axis within 45 deg of straight up.
  /// @throws InputError otherwise, and when parts of the panorama lie outside mirror or image.
  explicit MirrorView(const MountedCamera& omni, const MirrorViewParams& params = {});
  /// Without a rig: the camera points up, the top of the image is the front of the robot, and the
  /// right of the image is the left of the robot.
  /// @param raw  size of the images. @throws InputError as above.
  MirrorView(cv::Size raw, const MirrorRing& ring, const MirrorViewParams& params = {});

  /// Size of the raw images.
  [[nodiscard]] cv::Size RawSize() const { return raw_size_; }
  /// Size of the panoramas: columns x rows.
  [[nodiscard]] cv::Size Size() const { return size_; }
  /// The row of horizontal directions, counted from the centre of the top row; it may lie outside
  /// the panorama. Nothing for a mirror of unknown shape. With a tilted camera and rows by radius
  /// the horizontal directions form a band, and its centre row is returned.
  [[nodiscard]] std::optional<double> HorizonRow() const { return horizon_row_; }

  /// Unwraps an image.
  /// @param raw CV_8UC1 or CV_8UC3 of RawSize(). @param panorama becomes Size() of the same type;
  ///   it is allocated only when size or type differ, and must not share memory with `raw`.
  /// @throws InputError on another type or size. Thread-safe with a panorama per thread.
  void Unwrap(const cv::Mat& raw, cv::Mat& panorama) const;
  /// The same for a robot that is not level: the panorama is that of a level one at the same place.
  /// Directions that the tilted mirror does not show are those at its rim with the same azimuth in
  /// the camera. Cost: a new table, about 10 ms; a level robot costs as above.
  /// @throws InputError also for a mirror of unknown shape.
  void Unwrap(const cv::Mat& raw, const Tilt& tilt, cv::Mat& panorama) const;

 private:
  void MakeTable(const RemapTable::Source& source, Interpolation interpolation);
  void CheckRaw(const cv::Mat& raw) const;

  cv::Size raw_size_;
  cv::Size size_;
  std::optional<double> horizon_row_;
  RemapTable table_;
  /// The same for a tilted robot; empty for a mirror of unknown shape.
  std::function<RemapTable(const Tilt&)> tilted_table_;
};

}  // namespace ceilmap::calib
