#pragma once

#include <mutex>
#include <vector>

#include "mapping/registration/fft.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {

/// One block of the fine stage in the reference image.
struct ReferenceBlock {
  ComplexArray spectrum;  ///< of the windowed block
  double texture = 0;  ///< sharpness of its correlation peak in the worst direction, see BlockStage
  bool blank = false;  ///< constant grey level (black, saturated): no information
};

/// An image at one resolution of the fine stage.
struct Level {
  RealArray grey;         ///< grey levels 0..255, row-major
  float noise_sigma = 0;  ///< for the whitening (WhiteningNoise), grey levels
  float white_sigma = 0;  ///< of white noise in `grey`, grey levels
  /// Area without content: integral (CV_32S) of the pixels without content; empty: only that of the
  /// common mask (RegistrarParams::mask).
  cv::Mat blank;
  std::vector<ReferenceBlock> blocks;  ///< of the grid; only of a reference
};

/// Noise power of two images for their whitening, grey levels squared. A codec encodes all images
/// of a video: where only one has little noise, it is blurred by motion.
inline double WhiteningPower(float noise_a, float white_a, float noise_b, float white_b) {
  const bool encoded = noise_a > white_a && noise_b > white_b;
  return encoded ? double{noise_a} * noise_b : double{white_a} * white_b;
}

/// Data of a FrameSpectrum for the coarse stage. Immutable once computed.
struct FrameSpectrum::Coarse {
  RealArray flat;         ///< coarse working image: reduced, local mean removed
  ComplexArray spectrum;  ///< of `flat` under the window
  ComplexArray rings;     ///< polar amplitude profiles, transformed (PolarSearch)
  float noise_sigma = 0;  ///< of the image at full resolution (WhiteningNoise), grey levels
  float white_sigma = 0;  ///< of its white noise, grey levels
  float contrast = 0;     ///< standard deviation of `flat`, grey levels; 0 of overexposed images
};

/// Data of a FrameSpectrum for the fine stage. Immutable once computed, except for the levels'
/// blocks, which the first registration against this image computes once, under the lock.
struct FrameSpectrum::Fine {
  float white_sigma = 0;  ///< of white noise at full resolution, grey levels
  bool encoded = false;   ///< at a low bitrate, or denoised
  bool impulses = false;  ///< the image has impulse noise, which was removed (WithoutImpulses)
  Level fine;             ///< the image, reduced if it is very large (FineStage)
  Level rough;            ///< half the resolution of `fine`

  std::mutex blocks_mutex;
  bool rough_ready = false;
  bool fine_ready = false;
};

}  // namespace ceilmap::registration
