#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/local_features.hpp"
#include "mapping/registration/poc.hpp"
#include "mapping/registration/polar.hpp"
#include "mapping/registration/registration.hpp"

namespace ceilmap::registration {

/// Candidate rotations.
struct RotationRange {
  double theta_rad = 0;
  double reach_rad = 0;
};

/// A candidate motion of the coarse stage.
struct Hypothesis {
  ImageMotion motion;      ///< full pixels
  double peak = 0;         ///< of the POC surface, 0..1
  double correlation = 0;  ///< normalised cross-correlation over the common area, -1..1
  double overlap = 0;      ///< common area, fraction of the reference
  double score =
      0;  ///< peak + correlation * sqrt(overlap): the more common area, the less is chance
  FeatureEvidence features;  ///< of a motion proposed by features: no peak, correlation and score
};

/// The coarse stage of registration, RI-POC: rotation (and scale) by PolarSearch on the amplitude
/// spectra; then, for each proposed rotation, the current image is rotated back and phase-only
/// correlation gives translations; both half turns come from one transform, because the spectrum of
/// an image turned by 180 degrees is its conjugate up to a phase. Translations are tested with
/// their wrapped alternatives (t +- W, t +- H) on the common area.
class CoarseStage {
 public:
  /// @param mask  See RegistrarParams::mask; empty: images have content everywhere.
  explicit CoarseStage(cv::Size size, const cv::Mat& mask = {});

  [[nodiscard]] cv::Size WorkingSize() const { return work_; }

  /// @param grey  CV_8UC1, checked by the caller. @param mask  WorkingImage::mask; is copied.
  void Reduce(const cv::Mat& grey, const cv::Mat& mask, WorkingImage& image) const;

  /// Fills the data of the coarse stage. @param noise  of the image at full resolution.
  void Analyze(const WorkingImage& image, const ImageNoise& noise, FrameSpectrum::Coarse& data);

  /// The coarse part of an image; analysed at the first call, thread-safe.
  const FrameSpectrum::Coarse& Of(FrameSpectrum::Data& data);

  /// Coarse::ShowsTexture for images that may not need the spectra of Of; once, thread-safe.
  bool ShowsTexture(FrameSpectrum::Data& data);

  /// Possible motions, best score first; may be empty.
  /// @param near  Only rotations within this range are tried, which takes half the time when it
  /// determines the half turn.
  std::vector<Hypothesis> Propose(const FrameSpectrum::Coarse& reference,
                                  const FrameSpectrum::Coarse& current,
                                  bool estimate_scale,
                                  const std::optional<RotationRange>& near = std::nullopt);

 private:
  void Flatten(const WorkingImage& image, FrameSpectrum::Coarse& data);
  [[nodiscard]] std::vector<float> FadingMask(const cv::Mat& mask) const;
  void LocalMean();
  bool LimitLamps(const std::vector<float>& fading);
  void FadeToMean(const std::vector<float>& weights);
  /// The current image after the inverse of a rotation and a scale.
  struct TurnedBack {
    const RealArray& flat;
    const ComplexArray& spectrum;
  };
  /// The result is valid until the next call, and as long as `current`.
  TurnedBack TurnBack(const FrameSpectrum::Coarse& current, const RotationPeak& rotation);
  void ProposeShifts(const FrameSpectrum::Coarse& reference,
                     const FrameSpectrum::Coarse& current,
                     const RotationPeak& rotation,
                     const TurnedBack& turned,
                     bool half_turn,
                     std::vector<Hypothesis>& hypotheses);
  void TestShift(const FrameSpectrum::Coarse& reference,
                 const RotationPeak& rotation,
                 const TurnedBack& turned,
                 bool half_turn,
                 const PocPeak& peak,
                 std::vector<Hypothesis>& hypotheses) const;
  [[nodiscard]] std::vector<Hypothesis> Best(std::vector<Hypothesis> hypotheses) const;
  [[nodiscard]] ImageMotion ToFull(double theta_rad, double scale, double dx, double dy) const;

  cv::Size full_;
  int factor_ = 1;
  cv::Size work_;
  cv::Point start_;          // first full pixel of the working image
  std::vector<float> mask_;  // 1 inside, falling to 0 towards blank borders; empty: all 1
  std::vector<float> deviations_;
  PocPlane poc_;
  PolarSearch polar_;
  RealArray reduced_;
  RealArray mean_;
  RealArray windowed_;
  RealArray turned_;
  ComplexArray turned_spectrum_;
};

}  // namespace ceilmap::registration
