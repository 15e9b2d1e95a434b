#pragma once

#include <Eigen/Core>
#include <vector>

#include "mapping/registration/kernels.hpp"

namespace ceilmap::registration {

/// The error that bicubic interpolation causes in the shift of a block (BlockShift::sampling).
/// Sampled at u pixels beside a pixel, content is shifted by about -kShift sin(2 pi u), less where
/// it is smooth: by the mean square of its frequencies, which the sharpness of the peak is. Under a
/// rotation the samples of a block lie at all u, and the shifts cancel; between images that are
/// only shifted they are the same in all blocks.
class SamplingError {
 public:
  /// @param window  of a block along one axis; its length is even.
  explicit SamplingError(const std::vector<float>& window);

  /// Pixels of the reference. @param map  From pixels of the block to those of the current image.
  /// @param sharpness  PocPeak::sharpness.
  [[nodiscard]] Eigen::Vector2d Expected(const kernels::Affine& map,
                                         const Eigen::Matrix2d& sharpness) const;

  /// Standard deviation of the squared window as a distribution along one axis, pixels: the shift
  /// of a block is the mean over this part of it.
  [[nodiscard]] double WindowSigma() const { return sigma_px_; }

 private:
  double middle_;  // a pixel of the block
  double sigma_px_;
};

}  // namespace ceilmap::registration
