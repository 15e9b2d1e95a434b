#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/mosaic/height_map.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Which places of a map are ceiling, or something that hangs below it. A wide lens also sees
/// walls, windows and furniture: on the reference plane they would be drawn around the room, where
/// no ceiling was seen.
///
/// A place is ceiling if keyframes measured a surface there that they see from below. A wall is a
/// vertical face: all of it is above one line of the floor, and no ray reaches a place behind it.
/// The ratio rho of a vertical face grows in proportion to the distance from the principal point,
/// that of a level surface is constant. Ducts, pipes and lamps have an underside, however low they
/// hang; furniture that stands on the floor has none. Places without a measurement belong to the
/// ceiling where it surrounds them.
class CeilingExtent {
 public:
  CeilingExtent() = default;
  /// @param keyframes  final poses; images are not used. @param heights  of the same keyframes.
  CeilingExtent(const std::vector<graph::Keyframe>& keyframes,
                const store::MapMetadata& metadata,
                const HeightMap& heights);

  /// Whether nothing is left out: no keyframe has heights.
  [[nodiscard]] bool empty() const { return inside_.empty(); }
  /// Box around the ceiling, map units; of no size where empty.
  [[nodiscard]] cv::Rect2d Bounds() const;
  /// CV_8UC1, 255 at the centres of the pixels of a grid that are ceiling, else 0; no matrix where
  /// empty. The value of a place does not depend on the window. Thread-safe.
  [[nodiscard]] cv::Mat Over(const cv::Rect& window, const store::MosaicGrid& grid) const;
  /// Adds places where something moves to LeftOutPlaces: those with most of their neighbours among
  /// them. They remain ceiling. @param spacing  of the places, map units.
  void AddMoving(const std::vector<cv::Point2d>& places, double spacing);
  /// What images see of the reference plane but is not ceiling, because walls and things below hide
  /// it; and where something moves.
  [[nodiscard]] const std::vector<store::LeftOut>& LeftOutPlaces() const { return left_out_; }

 private:
  store::MosaicGrid grid_;
  double reference_height_ = 0;  // of the reference plane above the camera, map units
  cv::Mat inside_;               // CV_8UC1 on grid_: from 128 on the place is ceiling
  std::vector<store::LeftOut> left_out_;
};

}  // namespace ceilmap::mosaic
