#pragma once

#include <opencv2/core.hpp>

#include "calib/ceiling_view.hpp"
#include "mapping/heights/height_field.hpp"
#include "mapping/mosaic/height_map.hpp"
#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::localization {

/// What a view shows of the map: for each of its pixels the place and the height there.
struct SeenSurface {
  cv::Mat places;  ///< CV_32FC2, x and y in the map, relative to `origin`
  cv::Mat ratios;  ///< CV_32FC1, inverse height ratio of the map
  cv::Point2d origin;
};

/// Heights of a map as a camera of another height sees them. Inverse height ratios of the map are
/// relative to its own camera's distance from the reference plane; those of the other camera follow
/// from the difference of the cameras' heights, which the two distances from the same plane give.
class DepthDrawing {
 public:
  /// @param heights, view  must outlive the object. @param view  of the robot being localized.
  DepthDrawing(const mosaic::HeightMap& heights,
               const store::MapMetadata& metadata,
               const calib::CeilingView& view);

  /// False where the map has no heights, or where they are not absolute: patches are then plane.
  [[nodiscard]] bool HasDepth() const { return !heights_.empty() && map_distance_ > 0; }

  /// The ratio of the other camera for a ratio of the map, both 1 on the reference plane.
  [[nodiscard]] double ToView(double map_rho) const;
  /// Its inverse.
  [[nodiscard]] double ToMap(double view_rho) const;

  /// Ratio of what each pixel of a view shows: the nearest surface on its ray. CV_32FC1 of the
  /// view's size, in steps of two pixels. Where the map knows nothing: 1. Some 10 ms for 640 x 480
  /// pixels.
  [[nodiscard]] cv::Mat Ratios(const mosaic::ViewPlacement& placement) const;

  /// Where the pixels of a view are in the map. @param ratios  see Ratios.
  [[nodiscard]] SeenSurface SurfaceOf(const mosaic::ViewPlacement& placement,
                                      const cv::Mat& ratios) const;
  [[nodiscard]] const mosaic::HeightMap& Heights() const { return heights_; }

  /// The ratios of a view on a grid of cells.
  [[nodiscard]] static heights::HeightField Field(const cv::Mat& ratios, heights::HeightField grid);

 private:
  const mosaic::HeightMap& heights_;
  const calib::CeilingView& view_;
  double map_distance_ = 0;  // of the cameras from the reference plane, map units
  double view_distance_ = 0;
};

}  // namespace ceilmap::localization
