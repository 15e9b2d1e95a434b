#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace ceilmap::registration {

/// Similarity motion between two images of the same size W x H:
///   x' = s R(theta) (x - c) + c + t,   R = [[cos, -sin], [sin, cos]],   c = ((W-1)/2, (H-1)/2)
/// takes a pixel x of the reference to the pixel x' of the current image that shows the same
/// point. u right, v down, so theta > 0 turns the content clockwise on the screen.
struct ImageMotion {
  double tx_px = 0;
  double ty_px = 0;
  double theta_rad = 0;  ///< in (-pi, pi]
  double scale = 1;      ///< > 0

  [[nodiscard]] ImageMotion Inverse() const;
  /// x' of x; both relative to the image's centre c.
  [[nodiscard]] Eigen::Vector2d Apply(const Eigen::Vector2d& x_centred) const;
};

/// first, then second: x'' = second(first(x)).
ImageMotion Compose(const ImageMotion& second, const ImageMotion& first);

/// How badly two images disagree under an exact motion: for each block of the reference that both
/// see, ln(1 + residual energy / expected energy), brightness and contrast of each block being
/// free. A block on which both show the same gives little, one that shows a mark in one image
/// only gives much.
struct Dissimilarity {
  double mean = 0;  ///< 0 when no block could be compared
  int blocks = 0;
  std::vector<float> by_block;  ///< of all the grid's blocks, < 0 where not both see it

  /// Nats below which this fraction (0..1) of the compared blocks lies; infinity when there are
  /// none.
  [[nodiscard]] double Quantile(double fraction) const;
};

/// What the blocks that both comparisons have in common say for the first and against the second,
/// in natural logarithms; negative when they speak for the second. Both must have the same
/// reference. Vignetting, noise and blur make small differences on every block, in favour of
/// whichever motion is the smaller one: only what goes beyond them counts.
double Evidence(const Dissimilarity& a, const Dissimilarity& b);

/// Part of the reference image (0..1) whose points the current one shows under the motion; to
/// about 1 %.
double OverlapOf(const ImageMotion& motion, cv::Size size);

}  // namespace ceilmap::registration
