#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "localization/compass/fft_compass.hpp"
#include "localization/compass/parallax_fit.hpp"
#include "localization/compass/sector_shifts.hpp"
#include "localization/compass/shift_distances.hpp"
#include "localization/compass/travel_track.hpp"

namespace ceilmap::compass {

/// A panorama that others may be compared with, in the form that FftCompass stores.
struct View {
  PanoramaSpectrum spectrum;  ///< may be dropped once it is only matched by ViewMatcher::Around
  PanoramaLines lines;
  PanoramaSpectrum thumb;  ///< a version with few pixels, to find places that were visited before
  TravelTrack::Spot spot;
  std::int64_t frame = 0;
};

/// Compares views of panoramas of one size. Turns are those of the robot from a reference to the
/// current view, counter-clockwise, rad.
class ViewMatcher {
 public:
  /// @throws InputError when no panorama can have this size.
  ViewMatcher(const FftCompassParams& params, cv::Size size, int channels);

  /// Fills all members but spot and frame; the view's memory is reused.
  void Analyze(const cv::Mat& panorama, View& view);

  /// The turn at which the views agree best in fields of view in a direction of travel (seen from
  /// the current view) and opposite to it, in steps of a column, in [-pi, pi).
  double LeastTurn(const View& reference, const View& current, double direction_rad);
  /// Turn and travel near a turn, with an expected direction of travel, or any direction.
  /// @return nothing when too few sectors agree, or when the result lies outside the search range.
  std::optional<ParallaxFit> Around(const View& reference,
                                    const View& current,
                                    double turn_rad,
                                    std::optional<double> direction_rad);
  /// Dissimilarity of two places, independent of the turn: 0 (identical) .. 1 (nothing in common)
  /// and above.
  double Difference(const View& reference, const View& current);

  [[nodiscard]] int Columns() const { return distances_.Columns(); }
  /// Squared distances for all shifts, columns, from the last call of LeastTurn.
  [[nodiscard]] const std::vector<double>& Squared() const { return squared_; }

 private:
  FftCompassParams params_;
  ShiftDistances distances_;
  SectorMatcher matcher_;
  ShiftDistances thumbs_;
  std::vector<double> squared_;
  std::vector<double> thumb_squared_;
  cv::Mat pooled_;
  cv::Mat grey_;
  cv::Mat thumb_;
};

}  // namespace ceilmap::compass
