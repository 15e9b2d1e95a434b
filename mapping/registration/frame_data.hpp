#pragma once

#include <mutex>
#include <vector>

#include "mapping/registration/fft.hpp"
#include "mapping/registration/local_features.hpp"
#include "mapping/registration/noise.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {

/// One block of the fine stage in the reference image.
struct ReferenceBlock {
  ComplexArray spectrum;  ///< of the windowed block
  double texture = 0;  ///< sharpness of its correlation peak in the worst direction, see BlockStage
  /// Agreement of the block with a perfect match in an image with the same noise, 0..1: near 1 for
  /// strong texture, near 0 where there is only noise.
  double content = 0;
  bool blank = false;  ///< constant grey level (black, saturated): no information
};

/// An image at one resolution of the fine stage.
struct Level {
  RealArray grey;    ///< grey levels 0..255, row-major
  ImageNoise noise;  ///< of `grey`
  /// Area without content: integral (CV_32S) of the pixels without content; empty: only that of the
  /// common mask (RegistrarParams::mask).
  cv::Mat blank;
  std::vector<ReferenceBlock> blocks;        ///< of the grid; only of a reference
  std::vector<ReferenceBlock> small_blocks;  ///< of the grid of DepthStage; only of its reference
};

/// Data of a FrameSpectrum for the coarse stage. Immutable once computed.
struct FrameSpectrum::Coarse {
  RealArray flat;         ///< coarse working image: reduced, local mean removed
  ComplexArray spectrum;  ///< of `flat` under the window
  ComplexArray rings;     ///< polar amplitude profiles, transformed (PolarSearch)
  ImageNoise noise;       ///< of the image at full resolution
  float contrast = 0;     ///< standard deviation of `flat`, grey levels; 0 of overexposed images
};

/// Data of a FrameSpectrum for the fine stage. Immutable once computed, except for the levels'
/// blocks and the features, which the first registration that needs them computes once, under the
/// lock.
struct FrameSpectrum::Fine {
  ImageNoise noise;       ///< of the image at full resolution
  bool impulses = false;  ///< the image has impulse noise, which was removed (WithoutImpulses)
  Level fine;             ///< the image, reduced if it is very large (FineStage)
  Level rough;            ///< half the resolution of `fine`
  Level broad;            ///< half the resolution of `rough`; of JointStage

  std::mutex blocks_mutex;
  bool rough_ready = false;
  bool fine_ready = false;
  bool small_ready = false;
  bool broad_ready = false;
  LocalFeatures features;  ///< of `rough`
  bool features_ready = false;
};

}  // namespace ceilmap::registration
