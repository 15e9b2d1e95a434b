#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/graph/keyframe.hpp"
#include "mapping/mosaic/ratio_raster.hpp"
#include "mapping/store/map_file.hpp"

namespace ceilmap::mosaic {

/// Fills gaps of a raster by the surfaces beside them; of several by the farther one, because a gap
/// is what the nearer one hides from most images. Gaps of pixels that are not known are filled to
/// kFillReach pixels from their border, and those of refuted surfaces (negative) from 16: nothing
/// hides what is around these. A refuted surface without any around it is restored.
RatioRaster FillGaps(const RatioRaster& raster, int threads);
inline constexpr int kFillReach = 5;

/// Refutes surfaces through which more keyframes see, to something behind them, than confirm them:
/// a fan that turns, or a wrong measurement. What surrounds them replaces them.
/// @param keyframes  final poses; images are not used.
/// @param threads  0: as many as the machine has cores.
RatioRaster ReplaceSeenThrough(const RatioRaster& raster,
                               const std::vector<graph::Keyframe>& keyframes,
                               const store::MapMetadata& metadata,
                               int threads);

/// Part of the images of a place that agree on what is there, 0..1, if its surface has the ratio
/// rho; 1 where too few show it. Called by several threads.
using ImageAgreement = std::function<double(const cv::Point2d& p_map, float rho)>;

struct SettledSurfaces {
  RatioRaster raster;
  /// Centres of changed pixels that no surface explains, map units: something moves there.
  std::vector<cv::Point2d> moving;
};

/// Compares the surfaces with the images, in three steps.
/// 1. A surface is refuted that fewer than 15 % of at least 8 keyframes confirm, and on which less
///    than 75 % of the images agree.
/// 2. So are surfaces among refuted ones (30 % of their neighbours) on which the images do not
///    agree: parts of the same moving thing that several keyframes happened to measure.
/// 3. What is around a refuted surface replaces it, unless some other surface explains the images
///    and they agree less on the replacement than on the refuted one.
SettledSurfaces SettleSurfaces(const RatioRaster& raster,
                               const std::vector<graph::Keyframe>& keyframes,
                               const store::MapMetadata& metadata,
                               const ImageAgreement& agreement,
                               int threads);

}  // namespace ceilmap::mosaic
