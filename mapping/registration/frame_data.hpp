#pragma once

#include <mutex>
#include <optional>
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

/// What CoarseStage::Analyze needs of an image.
struct WorkingImage {
  RealArray grey;  ///< grey levels, reduced, row-major
  /// CV_8UC1 of the full image's size, 0 where it has no content in addition to the common mask;
  /// empty: it has content everywhere.
  cv::Mat mask;
  bool overexposed = false;  ///< most of it is white: what is left shows too little
};

/// Data of a FrameSpectrum for the coarse stage. Immutable once computed.
struct FrameSpectrum::Coarse {
  RealArray flat;         ///< coarse working image: reduced, local mean removed
  ComplexArray spectrum;  ///< of `flat` under the window
  ComplexArray rings;     ///< polar amplitude profiles, transformed (PolarSearch)
  ImageNoise noise;       ///< of the image at full resolution
  float contrast = 0;     ///< standard deviation of `flat`, grey levels; 0 of overexposed images

  [[nodiscard]] bool ShowsTexture() const {
    constexpr float kMinContrast = 0.25F;
    return contrast >= kMinContrast;
  }
};

/// All data of a FrameSpectrum. Immutable once computed, except for what not every image needs: the
/// coarse part, the levels' blocks and the features. The first registration that needs them
/// computes them once, under the lock.
struct FrameSpectrum::Data {
  ImageNoise noise;  ///< of the image at full resolution, without impulse noise (WithoutImpulses)
  double pixel_rate_bit_s = 0;  ///< Encoding::pixel_rate_bit_s
  WorkingImage working;
  Level fine;   ///< the image, reduced if it is very large (FineStage)
  Level rough;  ///< half the resolution of `fine`
  Level broad;  ///< half the resolution of `rough`; of JointStage

  std::mutex mutex;  ///< of all below and the blocks of the levels
  Coarse coarse;     ///< CoarseStage::Of
  bool coarse_ready = false;
  bool contrast_ready = false;  ///< only Coarse::flat and contrast
  std::optional<bool> unique;   ///< PlaneSearch::IsUnique
  bool rough_ready = false;
  bool fine_ready = false;
  bool small_ready = false;
  bool broad_ready = false;
  LocalFeatures features;  ///< of `rough`
  bool features_ready = false;

  /// Frees the blocks of the levels.
  void ReleaseBlocks() {
    for (Level* const level : {&fine, &rough, &broad}) {
      level->blocks = std::vector<ReferenceBlock>();
      level->small_blocks = std::vector<ReferenceBlock>();
    }
    rough_ready = fine_ready = small_ready = broad_ready = false;
  }
};

}  // namespace ceilmap::registration
