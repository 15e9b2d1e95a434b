#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/fft.hpp"

namespace ceilmap::compass {

/// A panorama in the form that SectorMatcher uses; memory is reused.
struct PanoramaLines {
  /// A line is a row of one channel, with its local mean (over 8 deg) subtracted; line by line, W
  /// samples each.
  registration::RealArray samples;
  registration::RealArray energy;  ///< squares of the samples, summed over the lines: by column
  registration::RealArray slopes;  ///< squares of their slopes along the line, in the same way
};

/// The motion of the content in one direction.
struct SectorShift {
  /// Where the sector's content is, seen from the current place, in (-pi, pi].
  double azimuth_rad = 0;
  /// The decrease of azimuths there, positive in a left turn; within SectorMatcher::kSearchRad of
  /// the expected shift.
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
  static constexpr int kSectors = 36;  ///< evenly spaced around the circle
  /// Range of shifts searched to either side of the expected one: at least the largest shift that
  /// travel may cause at the sides.
  static constexpr double kSearchRad = 0.175;

  SectorMatcher(cv::Size size, int channels);

  /// @param panorama  CV_8UC1 or CV_8UC3 as given to the constructor.
  /// Time is proportional to the number of rows; about twelve averaged rows are sufficient.
  void Analyze(const cv::Mat& panorama, PanoramaLines& lines);

  /// @param expected_columns  Expected shift of the reference's content to the right.
  /// @return the sectors with a valid shift; valid until the next call.
  std::span<const SectorShift> Measure(const PanoramaLines& reference,
                                       const PanoramaLines& current,
                                       double expected_columns);

 private:
  void Compare(const PanoramaLines& reference, const PanoramaLines& current, int expected);
  void MeasureSector(const PanoramaLines& reference,
                     const PanoramaLines& current,
                     int sector,
                     int expected);
  [[nodiscard]] double Energy(const PanoramaLines& lines, int first) const;
  [[nodiscard]] double Centroid(const PanoramaLines& lines, int first) const;

  int columns_;
  int rows_;
  int channels_;
  int reach_;                  ///< columns searched to either side
  std::vector<float> window_;  ///< window of a sector, odd length
  int stride_;                 ///< row stride of volume_: the columns plus the width of a window
  registration::RealArray volume_;  ///< squared distance by shift and column
  std::vector<float> row_;
  std::vector<float> doubled_;
  std::vector<double> cost_;
  std::vector<SectorShift> shifts_;
};

}  // namespace ceilmap::compass
