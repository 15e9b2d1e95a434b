#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calib/base/pose2.hpp"
#include "mapping/change/brightness_fit.hpp"
#include "mapping/change/cell_comparison.hpp"
#include "mapping/change/cells.hpp"
#include "mapping/mosaic/height_map.hpp"
#include "mapping/mosaic/view_placement.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::change {

/// An image of the ceiling at a known place of the map, as a level camera sees it.
struct PlacedView {
  cv::Mat grey;  ///< CV_8UC1, rectified and level: 0 exactly where there is no content
  cv::Mat mask;  ///< CeilingView::Mask; empty: content everywhere
  mosaic::ViewPlacement placement;
  double units_per_px = 0;
};

/// An image compared with the map, cell by cell.
struct ViewComparison {
  cv::Rect cells;  ///< around the image; empty where it shows none
  cv::Mat states;  ///< CV_8UC1 of CellState, of the size of `cells`
  /// CV_32FC3: CellDifference's log_ratio, signal and other; 0 where a lamp is.
  cv::Mat differences;
  cv::Mat weights;  ///< CV_32FC1, 0..1: how central a cell is in the image
  /// CV_8UC1, the image drawn over PixelsOf(cells), as bright as the map; 0 where there is none.
  cv::Mat levelled;
  BrightnessFit fit;      ///< image / map, over pixels of the mosaic
  double noise = 0;       ///< variance of the noise of `levelled`, grey levels squared
  double cell_noise = 0;  ///< of both smoothed images, as Compare takes it
  int lamps_alike = 0;    ///< cells with a lit lamp in both
  int lamps_differ = 0;   ///< cells with a lit lamp in one of the two
};

/// The heights of a map, for ViewComparer; empty where the map has none.
/// @param threads  0: as many as the machine has cores.
mosaic::HeightMap HeightsOf(const store::MapReader& map, int threads);

/// Compares images of known pose with the mosaic of a map. Both are smoothed a little, so that
/// noise, and a sharper lens, count less. About 10 ms for 640 x 480 pixels. Contains scratch
/// memory: one object per thread.
class ViewComparer {
 public:
  /// @param map  with a mosaic. @param heights  of the map; empty: one plane. Both must outlive the
  /// object.
  ViewComparer(const store::MapReader& map, const mosaic::HeightMap& heights);

  [[nodiscard]] ViewComparison Compare(const PlacedView& view);
  /// ViewComparison::fit alone, without the comparison of cells; no light where the image lies
  /// outside of the mosaic.
  [[nodiscard]] BrightnessFit FitTo(const PlacedView& view);

 private:
  /// Saturated pixels of a cell: of lamps that may be narrower than it, such as tubes.
  struct LampPixels {
    int alike = 0;   ///< in both images
    int differ = 0;  ///< in one, and no light near them in the other
  };

  void Smooth();
  void Draw(const PlacedView& view, const cv::Rect& window);
  [[nodiscard]] bool IsWhole(const cv::Rect& cell) const;
  void LevelBy(const BrightnessFit& fit, const cv::Rect& window);
  [[nodiscard]] BrightnessFit Fit(const cv::Rect& cells) const;
  [[nodiscard]] double NoiseOf(const ViewComparison& result) const;
  [[nodiscard]] cv::Mat WeightsOf(const PlacedView& view, const cv::Rect& cells) const;
  [[nodiscard]] LampPixels LampsIn(const cv::Rect& cell, double gain) const;
  void Judge(const cv::Point& at, ViewComparison& result) const;

  const store::MapReader& map_;
  const mosaic::HeightMap& heights_;
  cv::Mat seen_;                // drawn over the window
  cv::Mat valid_;               // 255 where image and map have content
  cv::Mat stored_;              // the map
  cv::Mat smooth_a_;            // of the map, CV_32FC1
  cv::Mat smooth_b_;            // of the image, CV_32FC1; after LevelBy as bright as the map
  cv::Mat gains_;               // CV_32FC1, image / map, one for each cell
  cv::Mat lit_stored_;          // 255 where a lamp of the map is lit
  cv::Mat lit_seen_;            // of the image
  cv::Mat bright_;              // of one of the two
  cv::Mat around_stored_;       // the brightest pixel near each, of the map
  cv::Mat around_seen_;         // of the image
  std::vector<CellSums> sums_;  // of each cell, row by row; no pixels where it is not whole
};

}  // namespace ceilmap::change
