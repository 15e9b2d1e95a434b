#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "mapping/heights/height_field.hpp"
#include "mapping/registration/block_stage.hpp"
#include "mapping/registration/depth_fit.hpp"
#include "mapping/registration/fine_stage.hpp"
#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {

/// Registration under a ceiling with depth: small blocks, each sampled where its height predicts
/// it, and FitDepthMotion. A motion must be known to about 16 pixels; the heights of the reference
/// may be unknown: where the plane moves more than a few block searches, blocks of unknown height
/// are then swept along the line of travel (plane sweep), which takes some ten times as long.
/// Motions and heights in the interface are those of full pixels.
class DepthStage {
 public:
  DepthStage(cv::Size size, const RegistrarParams& params);

  /// Prepares `data` as a reference; once, thread-safe. Match and MatchTilted need
  /// FineStage::PrepareRough besides.
  void PrepareReference(FrameSpectrum::Data& data);

  /// The grid of cells, one for each small block; all unknown.
  [[nodiscard]] const heights::HeightField& Unknown() const { return unknown_; }

  /// Result: kOk or kNoMatch; `peak` and `heights` are set.
  Registration Match(const FrameSpectrum::Data& reference,
                     const heights::HeightField& known,
                     const FrameSpectrum::Data& current,
                     const ImageMotion& start);

  /// The motion with tilt, from one that is known to about 16 pixels.
  PlaneFit MatchTilted(const FrameSpectrum::Data& reference,
                       const heights::HeightField& known,
                       const FrameSpectrum::Data& current,
                       const PlaneMotion& start);

  /// Heights on the grid of this stage: those of a map file may be on another one.
  [[nodiscard]] heights::HeightField OnGrid(const heights::HeightField& known) const;

  /// Places of blocks whose heights are known, where `motion` and the heights predict them; in
  /// pixels of the full images, from their centres. @param count  Maximum number of blocks.
  std::vector<PlaneShift> Measure(const FrameSpectrum::Data& reference,
                                  const heights::HeightField& known,
                                  const FrameSpectrum::Data& current,
                                  const PlaneMotion& motion,
                                  int count);

  /// `known`, refined by another image whose motion is known.
  heights::HeightField Refined(const FrameSpectrum::Data& reference,
                               const heights::HeightField& known,
                               const FrameSpectrum::Data& other,
                               const ImageMotion& motion);

  /// The heights of the current image, from those of the reference.
  [[nodiscard]] heights::HeightField Predicted(const heights::HeightField& known,
                                               const ImageMotion& motion) const;

 private:
  static constexpr int kSmallSearch = 3;  // px, of a small block beside where it is expected
  /// A fit at full resolution.
  struct SmallFit {
    DepthFit fit;
    heights::HeightField field;      // refined
    std::vector<PlaneShift> shifts;  // that were fitted
  };
  DepthFit FitRough(const FrameSpectrum::Data& reference,
                    const heights::HeightField& known,
                    const FrameSpectrum::Data& current,
                    const PlaneMotion& start,
                    bool fit_tilt);
  /// Measures and fits at full resolution from small.fit.motion.
  bool FitSmall(const FrameSpectrum::Data& reference,
                const heights::HeightField& known,
                const FrameSpectrum::Data& current,
                bool fit_tilt,
                SmallFit& small);
  bool FitShifts(const heights::HeightField& known,
                 const PlaneMotion& start,
                 double start_sigma_px,
                 bool fit_tilt,
                 SmallFit& small) const;
  bool FitLevel(const FrameSpectrum::Data& reference,
                const heights::HeightField& known,
                const FrameSpectrum::Data& current,
                const PlaneMotion& start,
                SmallFit& small);
  /// FitRough from `start`, then FitSmall. @return false where too few blocks agree.
  bool Fit(const FrameSpectrum::Data& reference,
           const heights::HeightField& known,
           const FrameSpectrum::Data& current,
           const PlaneMotion& start,
           bool fit_tilt,
           SmallFit& small);
  void MeasureAnyHeight(const FrameSpectrum::Data& reference,
                        const heights::HeightField& known,
                        const FrameSpectrum::Data& other,
                        const PlaneMotion& motion,
                        const std::vector<int>& chosen,
                        std::vector<PlaneShift>& shifts);
  [[nodiscard]] bool IsFar(const PlaneMotion& motion) const;
  [[nodiscard]] bool IsSwept(const heights::HeightField& known, const PlaneMotion& motion) const;
  void Sweep(const FrameSpectrum::Data& reference,
             const FrameSpectrum::Data& current,
             const PlaneMotion& motion,
             const std::vector<int>& chosen,
             std::vector<PlaneShift>& shifts);
  void MeasureSmall(const FrameSpectrum::Data& reference,
                    const heights::HeightField& known,
                    const FrameSpectrum::Data& current,
                    const PlaneMotion& motion,
                    const std::vector<int>& chosen,
                    std::vector<PlaneShift>& shifts,
                    int passes = 1);
  [[nodiscard]] ImageMotion OnFine(const PlaneMotion& motion) const;
  static void SetPriors(const heights::HeightField& known, std::vector<PlaneShift>& shifts);
  void Absorb(const DepthFit& fit,
              const std::vector<PlaneShift>& shifts,
              heights::HeightField& field) const;
  /// Of the motion of the image. @param covariance  DepthFit::covariance or spread.
  [[nodiscard]] Eigen::Matrix4d OfImage(const PlaneMotion& motion,
                                        const Eigen::Matrix<double, 6, 6>& covariance) const;
  [[nodiscard]] double MaxSigmaPx(const heights::HeightField& known,
                                  const PlaneMotion& motion) const;
  double ScaleToReference(const PlaneMotion& motion, heights::HeightField& field) const;
  [[nodiscard]] static bool EnoughAgree(const DepthFit& fit);

  RegistrarParams params_;
  LevelFrame fine_frame_;
  LevelFrame rough_frame_;  // its parent is the fine level
  PlaneCamera camera_;      // of the full image
  PlaneCamera fine_camera_;
  PlaneCamera rough_camera_;
  BlockStage rough_;
  BlockStage small_;
  heights::HeightField unknown_;
};

}  // namespace ceilmap::registration
