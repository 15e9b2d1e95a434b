#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>

#include "calib/remap_table.hpp"
#include "calib/rig.hpp"

namespace ceilmap::calib {

/// What the rows of a panorama are equidistant in.
enum class PanoramaRows : std::uint8_t {
  kRadius,        ///< from the centre of the mirror's image, as Labrosse unwraps
  kElevation,     ///< angle above the horizon
  kTanElevation,  ///< its tangent: what stands upright keeps its proportions, as on a cylinder
};

enum class Interpolation : std::uint8_t {
  kNearest,   ///< Labrosse's "not smooth"
  kBilinear,  ///< "smooth"
};

struct MirrorViewParams {
  int columns = 1080;  ///< 8 .. 16384, over the full circle
  int rows = 45;       ///< 1 .. 4096
  Interpolation interpolation = Interpolation::kBilinear;
  /// Nothing: elevation for a mirror of known shape, so that the horizon is one row, else radius,
  /// which is all that is known of a ring.
  std::optional<PanoramaRows> row_spacing = std::nullopt;
  /// Upper and lower edge of the panorama, in (-pi/2, pi/2), rad above the horizon; only for a
  /// mirror of known shape. Nothing above: as high as the mirror looks. Nothing below: as far below
  /// the horizon as above it, but between 15 and 30 deg, which leaves out the robot and the floor
  /// around it.
  std::optional<double> highest_elevation_rad = std::nullopt;
  std::optional<double> lowest_elevation_rad = std::nullopt;

  /// @throws InputError naming field, value and range.
  void Validate() const;
};

/// The camera under a convex mirror as the rest of the program sees it: a panorama, read from the
/// mirror's image by a scan line that rotates about its centre (Labrosse 2004).
///
/// Column u of W shows azimuth pi - 2 pi u / W, counter-clockwise from base's x axis: the robot's
/// front is column W/2, its left W/4, and the image reads like the room as a person sees it who
/// looks ahead, top row highest. When the robot turns left by w, the content moves to the RIGHT by
/// w W / (2 pi) columns. Rows are of equal height; the centre of row v lies (v + 1/2) / rows of the
/// way from the upper edge (outer circle) to the lower one.
///
/// A camera that is mounted turned about z keeps azimuth 0 at the robot's front. A tilt of camera
/// and mirror together is taken out where the mirror's shape is known. A mirror that stands off its
/// camera's axis, or tilted to it, is not modelled.
class MirrorView {
 public:
  /// @param omni  with `mirror` or `mirror_ring`; its optical axis within 45 deg of straight up.
  /// @throws InputError otherwise, and when parts of the panorama lie outside mirror or image.
  explicit MirrorView(const MountedCamera& omni, const MirrorViewParams& params = {});
  /// Without a rig: the camera looks up and the image's top is the robot's front, its right the
  /// robot's left.
  /// @param raw  size of the images. @throws InputError as above.
  MirrorView(cv::Size raw, const MirrorRing& ring, const MirrorViewParams& params = {});

  /// Of the raw images.
  [[nodiscard]] cv::Size RawSize() const { return raw_size_; }
  /// Of the panoramas: columns x rows.
  [[nodiscard]] cv::Size Size() const { return size_; }
  /// Where level directions lie, in rows from the top row's centre, inside the panorama or not;
  /// nothing for a mirror of unknown shape. The centre row of their band with a tilted camera and
  /// rows by radius.
  [[nodiscard]] std::optional<double> HorizonRow() const { return horizon_row_; }

  /// Unwraps an image.
  /// @param raw  CV_8UC1 or CV_8UC3 of RawSize(). @param panorama  becomes Size() of the same type;
  ///   allocates only when it is not yet, and must not share memory with `raw`.
  /// @throws InputError on another type or size. Thread-safe with a panorama per thread.
  void Unwrap(const cv::Mat& raw, cv::Mat& panorama) const;

 private:
  void MakeTable(const RemapTable::Source& source, Interpolation interpolation);

  cv::Size raw_size_;
  cv::Size size_;
  std::optional<double> horizon_row_;
  RemapTable table_;
};

}  // namespace ceilmap::calib
