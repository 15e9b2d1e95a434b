#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/fft.hpp"

namespace ceilmap::compass {

struct SectorParams {
  int sectors = 36;  ///< evenly around the circle, [12, 360]
  /// Of each sector (a raised cosine of twice this width at its foot), in (0, pi/2]. Narrow: what
  /// travel does within a sector is nearly one shift; wide: more to tell it by.
  double width_rad = 0.105;
  /// Shifts that are tried to either side of the expected one, in (0, pi/2]. At least what travel
  /// may move things at the sides.
  double search_rad = 0.175;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// A panorama as SectorMatcher keeps it; memory is reused.
struct PanoramaLines {
  /// A line is a row of one channel, without its mean; line by line, W samples each.
  registration::RealArray samples;
};

/// How the content moved in one direction.
struct SectorShift {
  double azimuth_rad = 0;  ///< the sector's middle, seen from the current place, in (-pi, pi]
  /// By how much azimuths fell there, as in a left turn; within search_rad of the expected shift.
  double shift_rad = 0;
  double variance_rad2 = 0;
};

/// Measures by how much the content of each sector of a panorama moved since another one: least
/// squared distance, sub-column by a parabola. Travel shows as shifts that differ around the
/// circle, which a single shift of the whole panorama cannot tell from a turn.
///
/// Holds scratch memory: one object per thread. No allocation after the first call.
class SectorMatcher {
 public:
  /// @throws InputError for invalid parameters.
  SectorMatcher(cv::Size size, int channels, const SectorParams& params = {});

  /// @param panorama  CV_8UC1 or CV_8UC3 as given to the constructor.
  /// Time goes with the rows: a dozen of averaged ones tell as much as many.
  void Analyze(const cv::Mat& panorama, PanoramaLines& lines) const;

  /// @param expected_columns  by which the reference's content is expected to have moved to the
  ///   right. @return sectors that tell a shift; valid until the next call.
  std::span<const SectorShift> Measure(const PanoramaLines& reference,
                                       const PanoramaLines& current,
                                       double expected_columns);

 private:
  void Compare(const PanoramaLines& reference, const PanoramaLines& current, int expected);
  void MeasureSector(int sector, int expected);

  SectorParams params_;
  int columns_;
  int rows_;
  int channels_;
  int reach_;                       ///< columns searched to either side
  std::vector<float> window_;       ///< of a sector, odd count
  int stride_;                      ///< of volume_: columns, and a window's more
  registration::RealArray volume_;  ///< squared distance by shift and column
  std::vector<float> doubled_;
  std::vector<double> cost_;
  std::vector<SectorShift> shifts_;
};

}  // namespace ceilmap::compass
