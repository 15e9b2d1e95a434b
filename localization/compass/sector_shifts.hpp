#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/fft.hpp"

namespace ceilmap::compass {

struct SectorParams {
  int sectors = 36;  ///< evenly spaced around the circle, [12, 360]
  /// Width of each sector (a raised cosine of twice this width at its base), in (0, pi/2]. A narrow
  /// sector has nearly one shift under travel; a wide sector contains more texture.
  double width_rad = 0.105;
  /// Range of shifts searched to either side of the expected one, in (0, pi/2]. At least the
  /// largest shift that travel may cause at the sides.
  double search_rad = 0.175;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// A panorama in the form that SectorMatcher uses; memory is reused.
struct PanoramaLines {
  /// A line is a row of one channel, with its mean subtracted; line by line, W samples each.
  registration::RealArray samples;
};

/// The motion of the content in one direction.
struct SectorShift {
  double azimuth_rad = 0;  ///< the sector's centre, seen from the current place, in (-pi, pi]
  /// The decrease of azimuths there, positive in a left turn; within search_rad of the expected
  /// shift.
  double shift_rad = 0;
  double variance_rad2 = 0;
};

/// Measures how far the content of each sector of a panorama moved since another panorama: minimum
/// of the squared distance, interpolated to a fraction of a column by a parabola. Travel causes
/// shifts that vary around the circle; a single shift of the whole panorama cannot distinguish this
/// from a turn.
///
/// Holds scratch memory: one object per thread. No allocation after the first call.
class SectorMatcher {
 public:
  /// @throws InputError for invalid parameters.
  SectorMatcher(cv::Size size, int channels, const SectorParams& params = {});

  /// @param panorama  CV_8UC1 or CV_8UC3 as given to the constructor.
  /// Time is proportional to the number of rows; about twelve averaged rows are sufficient.
  void Analyze(const cv::Mat& panorama, PanoramaLines& lines) const;

  /// @param expected_columns  Expected shift of the reference's content to the right.
  /// @return the sectors with a valid shift; valid until the next call.
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
  int reach_;                  ///< columns searched to either side
  std::vector<float> window_;  ///< window of a sector, odd length
  int stride_;                 ///< row stride of volume_: the columns plus the width of a window
  registration::RealArray volume_;  ///< squared distance by shift and column
  std::vector<float> doubled_;
  std::vector<double> cost_;
  std::vector<SectorShift> shifts_;
};

}  // namespace ceilmap::compass
