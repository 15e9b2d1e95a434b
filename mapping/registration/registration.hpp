#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace ceilmap::registration {

/// How many blocks the last rounds of a registration measure.
enum class Effort {
  kFull,  ///< RegistrarParams::final_blocks
  /// Half of them where those are sufficient, for an image with which no other will be compared:
  /// near a sharp prior, where they determine the motion to 0.03 px at the corners of the image,
  /// standard deviation; in a measurement of tilt, where the camera is surely level.
  kTracking,
};

/// Similarity motion between two images of the same size W x H:
///   x' = s R(theta) (x - c) + c + t,   R = [[cos, -sin], [sin, cos]],   c = ((W-1)/2, (H-1)/2)
/// from a pixel x of the reference to the pixel x' of the current image that shows the same point.
/// u right, v down, so theta > 0 rotates the content clockwise on the screen.
struct ImageMotion {
  double tx_px = 0;
  double ty_px = 0;
  double theta_rad = 0;  ///< in (-pi, pi]
  double scale = 1;      ///< > 0

  [[nodiscard]] ImageMotion Inverse() const;
  /// x' of x; both relative to the image's centre c.
  [[nodiscard]] Eigen::Vector2d Apply(const Eigen::Vector2d& x_centred) const;
};

/// Composition: x'' = second(first(x)).
ImageMotion Compose(const ImageMotion& second, const ImageMotion& first);

/// Dissimilarity of two images under an exact motion: for each block of the reference that is in
/// both images, ln(1 + residual energy / expected energy), with free brightness and contrast of
/// each block. The value is small for equal content, and large for a mark in only one of the
/// images.
struct Dissimilarity {
  double mean = 0;  ///< 0 when no block could be compared
  int blocks = 0;
  std::vector<float> by_block;  ///< of all the grid's blocks, < 0 if not in both images

  /// Nats below which this fraction (0..1) of the compared blocks lies; infinity when there are
  /// none.
  [[nodiscard]] double Quantile(double fraction) const;
};

/// Log-likelihood ratio of the first motion to the second, from the blocks that both comparisons
/// have in common; negative when the second is more likely. Both must have the same reference.
/// Vignetting, noise and blur cause small differences on every block, in favour of the smaller
/// motion: only larger differences are used.
double Evidence(const Dissimilarity& a, const Dissimilarity& b);

/// Fraction of the reference image (0..1) whose points are in the current one under the motion; to
/// about 1 %.
double OverlapOf(const ImageMotion& motion, cv::Size size);

}  // namespace ceilmap::registration
