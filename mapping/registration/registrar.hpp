#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "mapping/heights/height_field.hpp"
#include "mapping/registration/encoding.hpp"
#include "mapping/registration/plane_motion.hpp"
#include "mapping/registration/registration.hpp"

namespace ceilmap::registration {

/// Result of a registration.
enum class Verdict {
  kOk,         ///< one motion explains the images, and no other does nearly as well
  kNoTexture,  ///< an image has no texture to register (uniform, black, saturated)
  kNoMatch,    ///< no motion brings the images to agreement: no or too little overlap
  kAmbiguous,  ///< several different motions explain the images about equally well (periodic
               ///< ceiling)
};
const char* ToString(Verdict verdict);

/// Prediction of the motion (odometry, a motion model, a compass). Where it is sharp and the
/// reference is not like itself at any other place, only the blocks near it are compared. Otherwise
/// rotations near it are tried first, others only when none of those explains the images; and it
/// chooses among motions that the images do not decide between. It is never averaged into the
/// result.
struct MotionPrior {
  ImageMotion motion;
  double sigma_px = 0;         ///< of tx and ty, > 0
  double sigma_theta_rad = 0;  ///< > 0
};

struct Registration {
  Verdict verdict = Verdict::kNoMatch;
  ImageMotion motion;  ///< reference -> current; valid if ok(), and one of several if kAmbiguous
  /// Of (tx_px, ty_px, theta_rad, ln scale), along the axes of the current image, from the
  /// residuals of the fine stage, with the noise that blocks share and the error of interpolation;
  /// of a ceiling with depth by a factor for all that blocks share (README.md, "Covariance"). The
  /// scale's row and column are zero when the scale is fixed at 1.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  double peak = 0;       ///< agreement of the images under the motion, 0..1
  double runner_up = 0;  ///< the same for the best different motion, 0..1
  double overlap = 0;    ///< fraction of the reference image visible in the current one, 0..1
  int blocks = 0;        ///< blocks of the fine stage that could be compared
  int inliers = 0;       ///< those that agree with the motion
  /// Other motions explain the images as well; only the prior selected this one (kOk) or could not
  /// (kAmbiguous). The images of such a place do not distinguish it from others.
  bool disambiguated_by_prior = false;
  /// By RegisterJointly or CorrectJointly: no block of the image shows the motion by itself.
  bool jointly = false;

  /// The same two parts by texture, of a registration with depth: of blocks with weak texture no
  /// more than a part can agree. Agreement of the blocks, and texture of those that agree, both as
  /// a part of the texture of all compared blocks, 0..1.
  double textured_peak = 0;
  double textured_inliers = 0;

  /// Heights of the reference, refined by this registration; only of a registration with depth.
  std::shared_ptr<const heights::HeightField> heights;
  /// Factor of the translation by which this registration corrected the scale of the reference's
  /// heights: translations that were measured with the earlier scale are wrong by it.
  double rescaled = 1;

  [[nodiscard]] bool ok() const { return verdict == Verdict::kOk; }
  /// Whether most blocks agree with one plane. Otherwise the ceiling may have depth.
  [[nodiscard]] bool IsPlane() const;
  /// Of RegisterWithDepth, where nothing was known of the heights: whether these may be believed. A
  /// large part of the blocks agrees, with sufficient evidence, and a part of the ceiling is
  /// clearly off the height of most of it.
  [[nodiscard]] bool ShowsDepth() const;
  /// The same where no plane explains the images: the alternative is to know nothing. A part of the
  /// texture agrees, and the heights may still be unknown.
  [[nodiscard]] bool IsBestGuess() const;
};

struct RegistrarParams {
  bool estimate_scale = false;  ///< false: scale 1 (level robot, one camera); true: 0.7 .. 1.4
  /// Where images have content (CeilingView::Mask): CV_8UC1 of the image's size, 0 where they
  /// have none; empty: everywhere. Blank borders would otherwise be matched with each other.
  cv::Mat mask;
  /// The images are frames of one recording: where both have no noise, a codec removed it, and a
  /// motion that the prior predicts needs less evidence. False: the reference may be drawn from a
  /// map, and that holds where the current image alone has no noise and Encoding::predicted.
  bool same_recording = true;
  /// Where the amplitude spectra propose no motion that explains the images (little in common,
  /// depth, perspective), matches of local features (SIFT) propose one. Other images take no
  /// longer; a pair of 640x480 without a match takes 10 ms more, and 20 to 30 ms once for each
  /// image.
  bool local_features = false;
  int final_blocks = 48;  ///< blocks of the last rounds
  /// Of the images, for ceilings with depth: the principal point must be known. Focal length 0: not
  /// known, and not needed for a level robot.
  PlaneCamera camera = {};

  /// Blocks that must agree, > 0.
  int min_inliers = 5;
  /// Agreement of rough blocks + fine blocks + 2 x POC peak of the whole images, 0..4, from which
  /// dissimilar images are accepted (other light, blur).
  double min_agreement = 1.8;
  /// Very dissimilar images must also agree by this in rough and fine blocks alone, 0..2: motion
  /// blur of more than 12 px in one image splits the peaks even of the rough blocks, which then
  /// agree on a place beside the true one (mapping/registration/README.md, "Limits of acceptance").
  double min_block_agreement = 1.12;
  /// A part of the ceiling may have changed (covered, moved, switched off): then at least this
  /// fraction of the blocks must agree, 0..1, and a fifth of them down to the noise. Not for small
  /// images, where such a fraction would be a few lines. 1: never.
  double min_partial_inliers = 0.6;
  /// Used as the POC peak in Refine, where it is not computed, 0..1.
  double refine_poc_peak = 0.3;
};

/// RegistrarParams for images of a view: mask and camera; the rest remains.
void SetForView(const calib::CeilingView& view, RegistrarParams& params);

/// Everything that is computed once of an image and kept: its working copies and spectra. What only
/// some registrations need is computed when the first one needs it. Cheap to copy and to share
/// between threads and between registrars of one image size and mask; made by a Registrar.
class FrameSpectrum {
 public:
  FrameSpectrum() = default;
  [[nodiscard]] bool empty() const { return !data_; }
  /// The image has less noise than a camera's sensor: it was encoded at a low bitrate, or denoised.
  /// Parts of it may be copies of earlier images. False for an empty spectrum.
  [[nodiscard]] bool IsEncoded() const { return CodingLoss() > 0; }
  /// Fraction of a sensor's white noise that a codec or a denoiser removed, 0..1, in the image as
  /// the camera took it: the more, the less of it is the ceiling. 0 for an empty spectrum.
  [[nodiscard]] double CodingLoss() const;
  /// The same of the image as it is: drawing it anew (rectified) smooths its noise too. The more,
  /// the larger its errors at high spatial frequencies. At least CodingLoss, about.
  [[nodiscard]] double SmoothingLoss() const;
  /// The image lost so much more of the sensor's noise than a sharp one that it is blurred by
  /// motion: a codec removes about the same from all images.
  /// @param sharp_loss  CodingLoss of the sharp image.
  [[nodiscard]] bool IsBlurredBeside(double sharp_loss) const;
  /// The codec was so coarse that the image consists mainly of parts of the images before.
  [[nodiscard]] bool IsDistorted() const;
  /// ... and it spent next to nothing on the images of the last seconds: they show the ceiling as
  /// it was before, although all blocks agree. Such an image may continue a motion, but finds no
  /// place. Of images that were not analysed with an Encoding it is not known: false.
  [[nodiscard]] bool IsStarved() const;
  /// With its CodingLoss, for an image that is drawn from this one.
  [[nodiscard]] Encoding GetEncoding() const;
  /// Heights of the ceiling in this image; nullptr: the ceiling is taken to be plane. A Registrar
  /// uses them where the image is the reference.
  [[nodiscard]] const heights::HeightField* Heights() const { return heights_.get(); }
  [[nodiscard]] const std::shared_ptr<const heights::HeightField>& SharedHeights() const {
    return heights_;
  }
  void SetHeights(std::shared_ptr<const heights::HeightField> heights) {
    heights_ = std::move(heights);
  }
  /// Frees the blocks and the coarse part, more than half of the memory, unless another
  /// FrameSpectrum shares the data. The next registration that needs it computes it again.
  void ReleaseBlocks();

  struct Coarse;
  struct Data;

 private:
  friend class Registrar;
  std::shared_ptr<Data> data_;
  std::shared_ptr<const heights::HeightField> heights_;
};

/// An image that is rectified and analysed once for all that register it: tilt, odometry, search.
struct AnalyzedImage {
  cv::Mat pixels;          ///< CV_8UC1, rectified; shared, never written to
  FrameSpectrum spectrum;  ///< of the pixels; may be empty
};

/// Registers images of the same size. Contains FFT plans and scratch memory: one object per thread.
class Registrar {
 public:
  /// Images whose shorter side is below 240 px have few blocks: their accuracy is a tenth of a
  /// pixel (96 px: a third), and they need more overlap. They take as long as images of twice their
  /// size.
  /// @throws InputError when a side has less than 96 or more than 16384 pixels.
  explicit Registrar(cv::Size size, const RegistrarParams& params = {});
  ~Registrar();
  Registrar(Registrar&&) noexcept;
  Registrar& operator=(Registrar&&) noexcept;

  /// @param grey  CV_8UC1 of the registrar's size. @param mask  The same, 0 where this image has no
  /// content in addition to the common mask (RegistrarParams::mask); empty: none.
  /// @throws InputError on another type or size.
  [[nodiscard]] FrameSpectrum Analyze(const cv::Mat& grey,
                                      const cv::Mat& mask = {},
                                      const Encoding& encoding = {});

  /// Motion that takes pixels of `reference` to pixels of `current`. The content of an image never
  /// causes an exception.
  [[nodiscard]] Registration Register(const FrameSpectrum& reference,
                                      const FrameSpectrum& current,
                                      const std::optional<MotionPrior>& prior = std::nullopt,
                                      Effort effort = Effort::kFull);
  /// As Register without a prior, of images that may show any two places, as a pair of unknown
  /// origin does: a match must be supported by more than a grid, which agrees everywhere
  /// (AliasingCheck); else it is ambiguous. A pair of 640x480 that matches takes 20 ms more, 65 ms
  /// where it shows a grid.
  [[nodiscard]] Registration RegisterAnyPlaces(const FrameSpectrum& reference,
                                               const FrameSpectrum& current);

  /// As Register where nothing is known of the heights of the reference, and the ceiling may have
  /// depth. The result has heights. @param start  A motion near which the true one may be, as the
  /// prior's: of a registration that takes the ceiling to be plane.
  [[nodiscard]] Registration RegisterWithDepth(
      const FrameSpectrum& reference,
      const FrameSpectrum& current,
      const std::optional<MotionPrior>& prior = std::nullopt,
      const std::optional<ImageMotion>& start = std::nullopt);

  /// Near a predicted motion, where the images have so weak a texture that Register finds none: the
  /// correlation of all blocks together (JointStage). The covariance is large in directions that
  /// the images do not determine, as along the only edge in view. Takes 2 ms for 640x480.
  [[nodiscard]] Registration RegisterJointly(const FrameSpectrum& reference,
                                             const FrameSpectrum& current,
                                             const MotionPrior& prior);

  /// The same as a correction of an expectation: mean and covariance of the motion as the images
  /// and the expectation together tell it, to be used in place of the expectation. Where the images
  /// tell nothing it is the expectation itself. @param covariance  of the expected (tx_px, ty_px,
  /// theta_rad). @return kOk, or kNoMatch where the images cannot be compared.
  [[nodiscard]] Registration CorrectJointly(const FrameSpectrum& reference,
                                            const FrameSpectrum& current,
                                            const ImageMotion& expected,
                                            const Eigen::Matrix3d& covariance);

  /// The grid of cells of height fields, nothing known.
  [[nodiscard]] const heights::HeightField& EmptyHeights() const;
  /// The heights of `current` as those of `reference` predict them. @param reference  has heights.
  [[nodiscard]] heights::HeightField PredictHeights(const FrameSpectrum& reference,
                                                    const ImageMotion& motion) const;
  /// Heights of `reference`, which has some, refined by another image under a known motion.
  [[nodiscard]] heights::HeightField RefineHeights(const FrameSpectrum& reference,
                                                   const FrameSpectrum& other,
                                                   const ImageMotion& motion);

  /// Disagreement of the images under an exact motion; errors of a codec count as differences. Two
  /// comparisons of the same reference can be weighed against each other (Evidence), with different
  /// current images too.
  [[nodiscard]] Dissimilarity Compare(const FrameSpectrum& reference,
                                      const FrameSpectrum& current,
                                      const ImageMotion& motion);

  /// Of a motion that the blocks found jointly, where one of the images is blurred by motion:
  /// whether it may be off by much of the blur. The blocks agree at either end of the blur, and the
  /// evidence for it grows with their number, not with its truth; but images leave more unexplained
  /// under a wrong motion.
  [[nodiscard]] bool IsHiddenByBlur(const FrameSpectrum& reference,
                                    const FrameSpectrum& current,
                                    const ImageMotion& motion);

  /// Part of the blocks of the image, 0..1, that show more than noise.
  [[nodiscard]] double TexturedRatio(const FrameSpectrum& spectrum);

  /// Part of the blocks, 0..1, that are less similar a little away from the motion than under it.
  /// Shading, dust and the errors of a codec stay at their place in the image: they agree with the
  /// motion zero, but hardly less with others near it. Takes as long as five comparisons.
  [[nodiscard]] double TellingRatio(const FrameSpectrum& reference,
                                    const FrameSpectrum& current,
                                    const ImageMotion& motion);

  /// The fine stage alone, from a motion that is known to about 10 px and 2 degrees (tracking on a
  /// map, checking a prediction). kOk or kNoMatch; other motions that might explain the images are
  /// not examined.
  [[nodiscard]] Registration Refine(const FrameSpectrum& reference,
                                    const FrameSpectrum& current,
                                    const ImageMotion& start);

  /// The plane-induced motion with pitch and roll (mapping/registration/README.md, "Plane-induced
  /// motion"), from a motion that is known to a few degrees, e.g. PlaneMotion::FromSimilarity of a
  /// Register result. The reference must be a level view. Two or three rounds of measuring and
  /// fitting; `ok` is false where too few blocks can be compared.
  [[nodiscard]] PlaneFit RefinePlane(const FrameSpectrum& reference,
                                     const FrameSpectrum& current,
                                     const PlaneCamera& camera,
                                     const PlaneMotion& start,
                                     const PlaneFitParams& params = {},
                                     Effort effort = Effort::kFull);

  /// The same under a ceiling with depth. @param reference  has heights; a level view.
  [[nodiscard]] PlaneFit RefineWithDepth(const FrameSpectrum& reference,
                                         const FrameSpectrum& current,
                                         const PlaneMotion& start);

  /// The measurements to which RefinePlane fits a motion, for fits of more than one motion to them:
  /// the positions of blocks of the reference in the current image, in pixels of the full images,
  /// from their centres. @param motion  known to about 2 px over the image. Needs no level
  /// reference.
  [[nodiscard]] std::vector<PlaneShift> MeasurePlane(const FrameSpectrum& reference,
                                                     const FrameSpectrum& current,
                                                     const PlaneCamera& camera,
                                                     const PlaneMotion& motion);

  /// The same under a ceiling with depth: smaller blocks, at places whose heights are known. Their
  /// indices are those of the cells of the heights.
  /// @param reference  has heights. @param motion  known, with the heights, to about 2 px.
  /// @param count  Maximum number of blocks, those with the most texture first.
  [[nodiscard]] std::vector<PlaneShift> MeasureWithDepth(const FrameSpectrum& reference,
                                                         const FrameSpectrum& current,
                                                         const PlaneMotion& motion,
                                                         int count);

 private:
  void Check(const cv::Mat& grey, const cv::Mat& mask) const;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ceilmap::registration
