#pragma once

#include <array>
#include <complex>
#include <vector>

namespace ceilmap::mosaic {

/// Brightness of an image for a ceiling of given brightness: log I = log E + log_gain[k] + v(r) +
/// Re(bands[k] exp(2 pi i flicker_hz t)), t of the pixel's row. The model compensates differences
/// of exposure between images, the camera's vignetting, and bands of flickering lamps in the rows
/// of a rolling shutter. It covers no other effect: reflections that move with the robot remain.
struct ExposureModel {
  /// Per keyframe, in the order of the observations' indices; mean 0: the mosaic has the mean
  /// brightness of the images.
  std::vector<double> log_gain;
  /// v(r) = a1 q + a2 q^2 + a3 q^3 with q = (r / half diagonal of the image)^2; v(0) = 0.
  std::array<double, 3> vignetting{};
  double flicker_hz = 0;
  /// Per keyframe; empty: none have bands. Those too weak to be seen are 0.
  std::vector<std::complex<double>> bands;

  /// Of a row exposed at this time after the image's stamp.
  [[nodiscard]] double LogBand(int keyframe, double row_s) const;
  /// v at q in [0, 1].
  [[nodiscard]] double LogVignetting(double q) const;
};

/// One observation of a point of the ceiling by a keyframe.
struct ExposureObservation {
  int point = 0;     ///< index of the ceiling point, >= 0
  int keyframe = 0;  ///< index of the keyframe, >= 0
  double q = 0;      ///< normalized squared radius in the image, as above
  double log_grey = 0;
  double row_s = 0;  ///< exposure of the row that shows it, after the image's stamp (RowTimes)
};

/// Gains and vignetting by linear least squares with Huber weights; the brightnesses of the points
/// are eliminated. Weak regularization towards 0 fixes what the observations leave undetermined:
/// the mean gain of keyframes that share no point with others, and the vignetting where no point is
/// observed at two radii.
///
/// @param observations  in any order; points observed only once are ignored.
/// @param rolling  Whether rows were exposed at different times: then bands of 100 or 120 Hz,
///   whichever explains more, are solved for too.
ExposureModel SolveExposure(int keyframes,
                            std::vector<ExposureObservation> observations,
                            bool rolling = false);

}  // namespace ceilmap::mosaic
