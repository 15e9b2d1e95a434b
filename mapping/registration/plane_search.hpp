#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "mapping/registration/coarse.hpp"
#include "mapping/registration/fine_stage.hpp"
#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {

/// Another motion with this part of the best agreement is a rival.
inline constexpr double kRivalRatio = 0.7;

/// The search for the motion between two images under a ceiling that is one plane: hypotheses of
/// the coarse stage, or of local features, are tested with blocks; the best ones are refined; and
/// one is chosen (rivals.hpp), by what it leaves unexplained, else by the prior. Internal to the
/// registrar.
class PlaneSearch {
 public:
  /// The references must outlive the object. @param size  of the images.
  PlaneSearch(CoarseStage& coarse, FineStage& fine, const RegistrarParams& params, cv::Size size)
      : coarse_(coarse), fine_(fine), params_(params), size_(size) {}

  /// With blocks alone, from the motion of a sharp prior to what is near it, in a part of the time
  /// of Find. kOk, or kNoMatch where only Find can tell: the prior is not sharp, the reference is
  /// not unique, or nothing near the prior explains the images.
  Registration FindNear(FrameSpectrum::Data& reference,
                        const FrameSpectrum::Data& current,
                        const MotionPrior& prior,
                        Effort effort);

  /// Near the prior first; where that finds nothing, everywhere; then by features, if
  /// RegistrarParams::local_features.
  Registration Find(FrameSpectrum::Data& reference,
                    FrameSpectrum::Data& current,
                    const std::optional<MotionPrior>& prior);

 private:
  /// Whether the image resembles itself nowhere else, at rotations that a prior leaves open:
  /// another image then cannot agree with it under two motions. Computed once for an image.
  bool IsUnique(FrameSpectrum::Data& image);
  bool ResemblesItself(FrameSpectrum::Data& image);
  Registration FindBySpectra(FrameSpectrum::Data& reference,
                             FrameSpectrum::Data& current,
                             const std::optional<MotionPrior>& prior,
                             const std::optional<RotationRange>& near);
  Registration FindByFeatures(FrameSpectrum::Data& reference,
                              FrameSpectrum::Data& current,
                              const std::optional<MotionPrior>& prior);
  void AddExpected(const MotionPrior& prior, std::vector<Hypothesis>& hypotheses) const;
  Registration Verify(FrameSpectrum::Data& reference,
                      const FrameSpectrum::Data& current,
                      const std::vector<Hypothesis>& hypotheses,
                      const std::optional<MotionPrior>& prior);
  Registration Choose(const FrameSpectrum::Data& reference,
                      const FrameSpectrum::Data& current,
                      const std::vector<Finalist>& finalists,
                      const std::optional<MotionPrior>& prior);

  CoarseStage& coarse_;
  FineStage& fine_;
  const RegistrarParams& params_;
  cv::Size size_;
};

}  // namespace ceilmap::registration
