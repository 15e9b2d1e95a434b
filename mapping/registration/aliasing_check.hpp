#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/level_frame.hpp"
#include "mapping/registration/periods.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {

/// What remains of the agreement of two images once their periodic parts are taken away.
struct AperiodicEvidence {
  int blocks = 0;  ///< in which the grain could be compared
  /// Mean over the blocks of the correlation of their grain, in standard deviations of chance, each
  /// -3..3.
  double grain = 0;
  /// The same at the best of the motions a period further.
  double grain_of_rival = 0;
  /// Whether the images have grain: the residual of both is more than noise.
  bool has_grain = false;
  int mark_px = 0;   ///< pixels of marks of either image in the common area
  double marks = 0;  ///< correlation of the images there, -1..1
};

/// Whether two images show the same place of a periodic ceiling, or only the same grid (perceptual
/// aliasing). The lines of a grid agree under each motion that differs from the true one by a
/// period, and at any other place as well; so do lamps, which fill tiles. Evidence for a match must
/// come from what is not periodic:
///
/// - the periods of the reference, from its autocorrelation (PeriodFinder);
/// - both images minus their periodic parts (AperiodicPart);
/// - the grain that is left must correlate block by block under the motion, clearly more than under
///   the motions a period further;
/// - or, where tiles have no grain of their own, small marks off the grid must agree.
///
/// Images without periods are accepted, as are those that show fewer than three tiles along their
/// shorter side, and those of which too little can be compared. Works on the
/// rough level (FineStage), of small images on the fine one. Contains buffers: one
/// object per thread. Internal to the registrar.
class AliasingCheck {
 public:
  /// @param size  of the images. @param params  of the registrar: mask.
  AliasingCheck(cv::Size size, const RegistrarParams& params);

  /// @param motion  that was found, reference -> current, full pixels.
  /// @return true where the images distinguish this motion from those a period further, and the
  /// place from others of the grid.
  [[nodiscard]] bool Distinguishes(const FrameSpectrum::Data& reference,
                                   const FrameSpectrum::Data& current,
                                   const ImageMotion& motion);

  /// What Distinguishes decides upon. std::nullopt: not judged, the reference has no period or
  /// too few blocks can be compared.
  [[nodiscard]] std::optional<AperiodicEvidence> Compare(const FrameSpectrum::Data& reference,
                                                         const FrameSpectrum::Data& current,
                                                         const ImageMotion& motion);

 private:
  [[nodiscard]] const Level& LevelOf(const FrameSpectrum::Data& data) const;
  [[nodiscard]] cv::Mat Flattened(const Level& level) const;

  LevelFrame fine_frame_;
  LevelFrame rough_frame_;  // its parent is the fine level
  bool small_;              // the fine level is compared
  cv::Size size_;           // of the level that is compared
  cv::Mat blank_;           // 255 where no image has content; empty: nowhere
  PeriodFinder periods_;
};

}  // namespace ceilmap::registration
