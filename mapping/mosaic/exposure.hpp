#pragma once

#include <array>
#include <vector>

namespace ceilmap::mosaic {

/// How bright an image shows a ceiling of given brightness: log I = log E + log_gain[k] + v(r).
/// It levels differences of exposure between images and the camera's vignetting; it does not know
/// about anything else (reflections that move with the robot stay).
struct ExposureModel {
  /// Per keyframe, in the order of the observations' indices; mean 0: the mosaic is as bright as
  /// the images are on average.
  std::vector<double> log_gain;
  /// v(r) = a1 q + a2 q^2 + a3 q^3 with q = (r / half diagonal of the image)^2; v(0) = 0.
  std::array<double, 3> vignetting{};

  /// v at q in [0, 1].
  [[nodiscard]] double LogVignetting(double q) const;
};

/// One look of one keyframe at one point of the ceiling.
struct ExposureObservation {
  int point = 0;     ///< index of the ceiling point, >= 0
  int keyframe = 0;  ///< index of the keyframe, >= 0
  double q = 0;      ///< squared radius in the image as above
  double log_grey = 0;
};

/// Gains and vignetting by linear least squares with Huber weights; the points' own brightnesses
/// are eliminated. A weak pull towards 0 decides what the observations leave open: the mean gain of
/// keyframes that see nothing in common with others, and the vignetting where no point is seen from
/// two radii.
///
/// @param observations  in any order; points seen only once are of no use but do no harm.
ExposureModel SolveExposure(int keyframes, std::vector<ExposureObservation> observations);

}  // namespace ceilmap::mosaic
