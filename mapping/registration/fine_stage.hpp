#pragma once

#include <Eigen/Core>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/registration/block_stage.hpp"
#include "mapping/registration/coarse.hpp"
#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/level_frame.hpp"
#include "mapping/registration/motion_covariance.hpp"
#include "mapping/registration/motion_fit.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {

/// A hypothesis after its test with blocks.
struct Candidate {
  ImageMotion motion;
  double overlap = 0;
  double poc_peak = 0;  ///< of the whole images, from the coarse stage
  double support = 0;   ///< sum of the peaks of the blocks that agree with one motion
  int inliers = 0;
  int blocks = 0;
  FeatureEvidence features;  ///< of a motion proposed by features

  [[nodiscard]] double Agreement() const { return support / std::max(blocks, 1); }
};

/// A candidate after the last rounds.
struct Finalist {
  Registration result;
  double agreement = 0;  ///< mean over the compared blocks of the peaks of those that agree
  /// Enough blocks agree on the motion, to sub-pixel accuracy; false: the fields below are not set.
  bool determined = false;
  double total_agreement = 0;    ///< RegistrarParams::min_agreement, 0..4
  double from_candidate_px = 0;  ///< change since the candidate, at the image's border
  Dissimilarity dissimilarity;   ///< see FineStage::Compare
  /// The motion would be accepted if the error of the codec counted as noise. That error covers
  /// what distinguishes places of a tiled ceiling, so it is sufficient for a predicted motion only.
  bool alike_but_for_codec = false;
  bool blurred = false;  ///< only the low band could be used
  /// Variances of (tx, ty, theta, ln scale) as if the blocks were independent, with which limits
  /// are compared; full pixels, along the axes of the reference.
  Eigen::Vector4d spread = Eigen::Vector4d::Zero();

  /// Standard deviation of the translation by `spread`, its larger axis.
  [[nodiscard]] double SpreadPx() const { return std::sqrt(spread.head<2>().maxCoeff()); }
};

/// The fine stage of registration on two levels: blocks of a rough level (half the resolution of
/// the fine one), which use the low band and are robust against noise and motion blur, and blocks
/// of the fine level, which are exact. The fine level is the image itself up to about 1200 pixels
/// and reduced above, so that a block always contains a sufficient part of the scene and the cost
/// is bounded. An image whose shorter side is below 240 pixels has too few blocks for a consensus
/// and is enlarged to twice its size. Motions in the interface are those of full pixels.
class FineStage {
 public:
  FineStage(cv::Size size, const RegistrarParams& params);

  /// Fills the levels of `data`, whose noise is known. @param grey  CV_8UC1. @param mask
  /// WorkingImage::mask.
  void Analyze(const cv::Mat& grey, const cv::Mat& mask, FrameSpectrum::Data& data) const;
  /// Prepares `data` as a reference; once, thread-safe.
  void PrepareReference(FrameSpectrum::Data& data);
  /// The same for RefinePlane only.
  void PrepareFine(FrameSpectrum::Data& data);
  /// The same for DepthStage.
  void PrepareRough(FrameSpectrum::Data& data);

  /// Motions on which local features of the images agree (MotionsOfFeatures); computes and keeps
  /// the features of an image once, thread-safe.
  /// @param known  Heights of the reference; nullptr: the ceiling is one plane.
  std::vector<Hypothesis> ProposeByFeatures(FrameSpectrum::Data& reference,
                                            FrameSpectrum::Data& current,
                                            const heights::HeightField* known = nullptr) const;

  /// True when Test would find the motion, starting at this one.
  [[nodiscard]] bool Reaches(const ImageMotion& start, const ImageMotion& motion) const;
  /// True when blocks agree on a motion near the hypothesis (within 16 fine pixels and about 3
  /// degrees).
  Candidate Test(const FrameSpectrum::Data& reference,
                 const FrameSpectrum::Data& current,
                 const Hypothesis& hypothesis);
  /// Refines a candidate to full accuracy; its result is kOk when it is accepted (RegistrarParams),
  /// else kNoMatch.
  Finalist Refine(const FrameSpectrum::Data& reference,
                  const FrameSpectrum::Data& current,
                  const Candidate& candidate,
                  Effort effort = Effort::kFull);
  /// Fills the dissimilarity of a finalist, in full pixels, unless it is already known.
  void Compare(const FrameSpectrum::Data& reference,
               const FrameSpectrum::Data& current,
               Finalist& finalist);

  /// Registrar::Compare.
  Dissimilarity Compare(const FrameSpectrum::Data& reference,
                        const FrameSpectrum::Data& current,
                        const ImageMotion& motion);

  /// Registrar::TexturedRatio. Prepares the fine blocks of the image.
  double TexturedRatio(FrameSpectrum::Data& data);

  /// Registrar::TellingRatio.
  double TellingRatio(const FrameSpectrum::Data& reference,
                      const FrameSpectrum::Data& current,
                      const ImageMotion& motion);

  /// PlaneMeasurement::Fit with blocks of the fine level.
  PlaneFit RefinePlane(const FrameSpectrum::Data& reference,
                       const FrameSpectrum::Data& current,
                       const PlaneCamera& camera,
                       const PlaneMotion& start,
                       const PlaneFitParams& params,
                       int rounds,
                       Effort effort);

  /// PlaneMeasurement::Measure with blocks of the fine level.
  std::vector<PlaneShift> MeasurePlane(const FrameSpectrum::Data& reference,
                                       const FrameSpectrum::Data& current,
                                       const PlaneCamera& camera,
                                       const PlaneMotion& motion,
                                       int count);

 private:
  const LocalFeatures& FeaturesOf(FrameSpectrum::Data& data) const;
  bool FeaturesAreSound(const FrameSpectrum::Data& reference,
                        const FrameSpectrum::Data& current,
                        const Candidate& candidate,
                        Finalist& finalist);
  bool AgreesUpToDepth(const FrameSpectrum::Data& reference,
                       const FrameSpectrum::Data& current,
                       Finalist& finalist);
  [[nodiscard]] bool IsAlike(const Finalist& finalist,
                             const Dissimilarity& dissimilarity,
                             bool agreed) const;
  Dissimilarity CompareRough(const FrameSpectrum::Data& reference,
                             const FrameSpectrum::Data& current,
                             const ImageMotion& motion,
                             double noise_power);
  void MeasureRough(const FrameSpectrum::Data& reference,
                    const FrameSpectrum::Data& current,
                    const ImageMotion& motion,
                    int count,
                    int search_px);
  void MeasureFine(const FrameSpectrum::Data& reference,
                   const FrameSpectrum::Data& current,
                   const ImageMotion& motion,
                   int count);
  void MeasureOtherFine(const FrameSpectrum::Data& reference,
                        const FrameSpectrum::Data& current,
                        const ImageMotion& motion);
  bool FitSharp(const FrameSpectrum::Data& reference,
                const FrameSpectrum::Data& current,
                Effort effort,
                Finalist& finalist);
  bool FitShifts(const SharedNoise& shared, Finalist& finalist) const;
  [[nodiscard]] double CornerSigma(const Finalist& finalist) const;
  bool IsSound(const FrameSpectrum::Data& reference,
               const FrameSpectrum::Data& current,
               const Candidate& candidate,
               Finalist& finalist);
  void InflateBlurCovariance(const FrameSpectrum::Data& reference,
                             const FrameSpectrum::Data& current,
                             Finalist& finalist);
  void LastRounds(const FrameSpectrum::Data& reference,
                  const FrameSpectrum::Data& current,
                  Effort effort,
                  Finalist& finalist);

  RegistrarParams params_;
  LevelFrame fine_frame_;
  LevelFrame rough_frame_;  // its parent is the fine level
  BlockStage rough_;
  BlockStage fine_;
  SharedNoise rough_shared_;  // of blocks, in fine pixels
  SharedNoise fine_shared_;
  std::vector<BlockShift> shifts_;  // in fine pixels
  std::vector<BlockShift> others_;  // of MeasureOtherFine
  std::vector<int> chosen_;         // blocks of the last MeasureFine
};

}  // namespace ceilmap::registration
