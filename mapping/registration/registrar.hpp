#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "mapping/registration/plane_motion.hpp"
#include "mapping/registration/registration.hpp"

namespace ceilmap::registration {

/// Result of a registration.
enum class Verdict {
  kOk,         ///< one motion explains the images, and no other one does nearly as well
  kNoTexture,  ///< an image has no texture (uniform, black, saturated)
  kNoMatch,    ///< the images agree under no motion: no or too little overlap
  kAmbiguous,  ///< several different motions explain the images about equally well (periodic
               ///< ceiling)
};
const char* ToString(Verdict verdict);

/// Prior of the motion (odometry, a motion model, a compass). Rotations near it are tried first,
/// others only when none of those explains the images; it also selects among motions that the
/// images cannot distinguish. It is never averaged into the result.
struct MotionPrior {
  ImageMotion motion;
  double sigma_px = 0;         ///< of tx and ty, > 0
  double sigma_theta_rad = 0;  ///< > 0
};

struct Registration {
  Verdict verdict = Verdict::kNoMatch;
  ImageMotion motion;  ///< reference -> current; only valid if ok()
  /// Of (tx_px, ty_px, theta_rad, ln scale), from the residuals of the fine stage; the scale's row
  /// and column are zero when the scale is fixed at 1.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  double peak = 0;       ///< agreement of the images under the motion, 0..1
  double runner_up = 0;  ///< the same for the best different motion, 0..1
  double overlap = 0;    ///< fraction of the reference image that the current one shows, 0..1
  int blocks = 0;        ///< blocks of the fine stage that could be compared
  int inliers = 0;       ///< those that agree with the motion
  /// Other motions explain the images as well; only the prior selected this one (kOk) or could not
  /// (kAmbiguous). The images of such a place do not distinguish it from others.
  bool disambiguated_by_prior = false;

  [[nodiscard]] bool ok() const { return verdict == Verdict::kOk; }
};

struct RegistrarParams {
  bool estimate_scale = false;  ///< false: scale 1 (level robot, one camera); true: 0.7 .. 1.4
  /// Where images have content (CeilingView::Mask): CV_8UC1 of the image's size, 0 where they
  /// have none; empty: everywhere. Blank borders would otherwise be matched with each other.
  cv::Mat mask;
  int first_blocks = 24;  ///< blocks that test a coarse hypothesis and bring it close
  int final_blocks = 48;  ///< blocks of the last rounds

  // When an answer is believed. Over 1300 pairs that have nothing in common, of eight scenes, the
  // support by chance was at most 4.1 with a sigma of 0.47 px, 2.5 and 0.4 px at the 99th
  // percentile; true motions have 5 and more (median 22) and below 0.33 px (median 0.003). Over 250
  // pairs of other places on one tiled ceiling, where the lines fit, `unlike` was 0.98 and more and
  // the agreement 1.62 and less; true motions have either `unlike` below 0.87 (noise) or agreement
  // above 1.94 (other light, blur, real recordings with moving sun).

  /// Sum of the peaks of agreeing blocks in the test of a hypothesis.
  double min_support = 4.2;
  /// Blocks that agree, ...
  int min_inliers = 5;
  /// ... and their part of the compared blocks after the last round.
  double min_inlier_ratio = 0.25;
  /// Of the translation, from the residuals.
  double max_sigma_px = 0.42;
  /// Mean ln(1 + unexplained / expected energy) of the blocks; or, where it is larger, ...
  double max_dissimilarity = 0.92;
  /// ... agreement of rough blocks + fine blocks + 2 x POC peak of the whole images, 0..4.
  double min_agreement = 1.8;
  /// The same of images whose shorter side is below 240 px: their few blocks see little but
  /// lines, which agreed by up to 2.25 over 2700 pairs of other places (96x96 to 220x220; with 240
  /// px and more by up to 1.76). What agrees by less must be alike.
  double min_agreement_small = 2.3;
  /// Where `unlike` is above `max_dissimilarity_weak`, rough and fine blocks alone must also agree
  /// by this: a smear of more than 12 px in one image splits the peaks even of the rough blocks,
  /// which then agree on a place beside the truth (1.09 and less, `unlike` 2.2 and more; images
  /// under other light have 1.15 and more).
  double max_dissimilarity_weak = 1.9;
  double min_block_agreement = 1.12;
  /// A part of what is seen may have changed (covered, moved, switched off): then at least this
  /// part of the blocks must agree as well as this, and a fifth of them down to the noise. At the
  /// true place with a fifth to a half changed the agreement was 0.37 and more and that fifth's
  /// `unlike` 1.1 and less; one tile further 0.32 and less, and 1.9 and more. Not for small
  /// images, where such a part would be a few lines.
  double min_partial_inliers = 0.6;
  double min_partial_agreement = 0.36;
  double max_partial_dissimilarity = 1.4;
  /// Stands for that POC peak in Refine, where it is not computed.
  double refine_poc_peak = 0.3;
  /// Grey levels; images with less show nothing.
  double min_contrast = 0.25;
  /// Another motion with this part of the best agreement is a rival, and ...
  double rival_ratio = 0.7;
  /// ... stays one unless the images speak against it by so many nats.
  double min_evidence = 4.5;
};

/// Data that are computed once per image: its working copies and spectra. Cheap to move and to
/// share (the data are immutable); created by Registrar::Analyze.
class FrameSpectrum {
 public:
  FrameSpectrum() = default;
  [[nodiscard]] bool empty() const { return !data_; }
  struct Data;

 private:
  friend class Registrar;
  std::shared_ptr<Data> data_;
};

/// Registers images of the same size. Contains FFT plans and scratch memory: one object per thread.
class Registrar {
 public:
  /// Images whose shorter side is below 240 px have few blocks: they are accurate to a tenth of a
  /// pixel (96 px: to a third), and fail earlier when much of their content is new. They take as
  /// long as images of twice their size.
  /// @throws InputError when a side has less than 96 or more than 16384 pixels.
  explicit Registrar(cv::Size size, const RegistrarParams& params = {});
  ~Registrar();
  Registrar(Registrar&&) noexcept;
  Registrar& operator=(Registrar&&) noexcept;

  /// @param grey  CV_8UC1 of the registrar's size. @param mask  The same, 0 where this image has no
  /// content in addition to the common mask (RegistrarParams::mask); empty: none.
  /// @throws InputError on another type or size.
  [[nodiscard]] FrameSpectrum Analyze(const cv::Mat& grey, const cv::Mat& mask = {});

  /// The same for Refine and RefinePlane only, in a third of the time: sufficient for a frame whose
  /// motion is approximately known.
  [[nodiscard]] FrameSpectrum AnalyzeFine(const cv::Mat& grey, const cv::Mat& mask = {});

  /// Motion from pixels of `reference` to pixels of `current`. Never throws because of image
  /// content. @throws std::invalid_argument for spectra of AnalyzeFine.
  [[nodiscard]] Registration Register(const FrameSpectrum& reference,
                                      const FrameSpectrum& current,
                                      const std::optional<MotionPrior>& prior = std::nullopt);

  /// Dissimilarity of the images under an exact motion. Two comparisons of the same reference can
  /// be compared (Evidence), also with different current images.
  [[nodiscard]] Dissimilarity Compare(const FrameSpectrum& reference,
                                      const FrameSpectrum& current,
                                      const ImageMotion& motion);

  /// Only the fine stage, from a motion that is known to about 10 px and 2 degrees (tracking on a
  /// map, checking a prediction). kOk or kNoMatch; other motions that might explain the images too
  /// are not searched.
  [[nodiscard]] Registration Refine(const FrameSpectrum& reference,
                                    const FrameSpectrum& current,
                                    const ImageMotion& start);

  /// The plane-induced motion with pitch and roll, from a motion that is known to a few degrees,
  /// e.g. PlaneMotion::FromSimilarity of a Register result. The reference must be a level view. Two
  /// or three rounds of measuring and fitting; `ok` is false when too few blocks can be compared.
  [[nodiscard]] PlaneFit RefinePlane(const FrameSpectrum& reference,
                                     const FrameSpectrum& current,
                                     const PlaneCamera& camera,
                                     const PlaneMotion& start,
                                     const PlaneFitParams& params = {});

  /// The measurements of RefinePlane, for fits of more than one motion: positions of blocks of the
  /// reference in the current image, pixels of the full images relative to their centres. @param
  /// motion  Known to about 2 px over the image. The reference need not be level.
  [[nodiscard]] std::vector<PlaneShift> MeasurePlane(const FrameSpectrum& reference,
                                                     const FrameSpectrum& current,
                                                     const PlaneCamera& camera,
                                                     const PlaneMotion& motion);

 private:
  void Check(const cv::Mat& grey, const cv::Mat& mask) const;

  struct Pool;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::registration
