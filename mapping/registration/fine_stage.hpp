#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/registration/block_stage.hpp"
#include "mapping/registration/coarse.hpp"
#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/motion_fit.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {

/// A hypothesis after its test by blocks.
struct Candidate {
  ImageMotion motion;
  double overlap = 0;
  double support = 0;  ///< sum of the peaks of the blocks that agree with one motion
  int inliers = 0;
  int blocks = 0;

  [[nodiscard]] double Agreement() const { return support / std::max(blocks, 1); }
};

/// A candidate after the last rounds.
struct Finalist {
  Registration result;
  double agreement = 0;  ///< mean over the compared blocks of the peaks of those that agree
  double unlike = 0;     ///< BlockStage::Dissimilarity, filled in where finalists compete
  int unlike_blocks = 0;
};

/// The fine stage of registration on two levels: blocks of the half-resolution picture, which see
/// the low band, robust against noise and motion blur, and blocks of the full picture, which are
/// exact. Motions are those of full pixels.
class FineStage {
 public:
  FineStage(cv::Size size, const RegistrarParams& params);

  /// Fills the levels of `data`. @param grey  CV_8UC1, after CoarseStage::Analyze (the noise is
  /// taken from there).
  void Analyze(const cv::Mat& grey, FrameSpectrum::Data& data) const;
  /// Makes `data` able to be a reference; once, thread-safe.
  void PrepareReference(FrameSpectrum::Data& data) const;

  /// Do blocks agree on a motion near the hypothesis (within 16 px and about 3 degrees)?
  Candidate Test(const FrameSpectrum::Data& reference,
                 const FrameSpectrum::Data& current,
                 const Hypothesis& hypothesis);
  /// Brings a candidate to the last digit; its result is kOk when it can be believed
  /// (RegistrarParams), else kNoMatch.
  Finalist Refine(const FrameSpectrum::Data& reference,
                  const FrameSpectrum::Data& current,
                  const Candidate& candidate);
  /// Fills `unlike` of a finalist.
  void Compare(const FrameSpectrum::Data& reference,
               const FrameSpectrum::Data& current,
               Finalist& finalist);

  /// Plane motion from blocks of the full picture, measured and fitted `rounds` times from `start`.
  PlaneFit RefinePlane(const FrameSpectrum::Data& reference,
                       const FrameSpectrum::Data& current,
                       const PlaneCamera& camera,
                       const PlaneMotion& start,
                       const PlaneFitParams& params,
                       int rounds);

 private:
  void MeasureHalf(const FrameSpectrum::Data& reference,
                   const FrameSpectrum::Data& current,
                   const ImageMotion& motion,
                   int count,
                   int search_px);
  void MeasureFull(const FrameSpectrum::Data& reference,
                   const FrameSpectrum::Data& current,
                   const ImageMotion& motion,
                   int count);
  bool FitShifts(Finalist& finalist) const;
  void LastRounds(const FrameSpectrum::Data& reference,
                  const FrameSpectrum::Data& current,
                  Finalist& finalist);
  [[nodiscard]] ImageMotion ToHalf(const ImageMotion& full) const;

  RegistrarParams params_;
  cv::Size half_size_;
  Eigen::Vector2d half_offset_;  // x_full = 2 x_half + offset, both from the pictures' centres
  BlockStage half_;
  BlockStage full_;
  std::vector<BlockShift> shifts_;
};

}  // namespace ceilmap::registration
