#pragma once

#include <array>
#include <vector>

namespace ceilmap::mosaic {

/// Brightness of an image for a ceiling of given brightness: log I = log E + log_gain[k] + v(r).
/// The model compensates differences of exposure between images and the camera's vignetting. It
/// covers no other effect: reflections that move with the robot remain.
struct ExposureModel {
  /// Per keyframe, in the order of the observations' indices; mean 0: the mosaic has the mean
  /// brightness of the images.
  std::vector<double> log_gain;
  /// v(r) = a1 q + a2 q^2 + a3 q^3 with q = (r / half diagonal of the image)^2; v(0) = 0.
  std::array<double, 3> vignetting{};

  /// v at q in [0, 1].
  [[nodiscard]] double LogVignetting(double q) const;
};

/// One observation of a point of the ceiling by a keyframe.
struct ExposureObservation {
  int point = 0;     ///< index of the ceiling point, >= 0
  int keyframe = 0;  ///< index of the keyframe, >= 0
  double q = 0;      ///< normalized squared radius in the image, as above
  double log_grey = 0;
};

/// Gains and vignetting by linear least squares with Huber weights; the brightnesses of the points
/// are eliminated. Weak regularization towards 0 fixes what the observations leave undetermined:
/// the mean gain of keyframes that share no point with others, and the vignetting where no point is
/// observed at two radii.
///
/// @param observations  in any order; points observed only once are ignored.
ExposureModel SolveExposure(int keyframes, std::vector<ExposureObservation> observations);

}  // namespace ceilmap::mosaic
