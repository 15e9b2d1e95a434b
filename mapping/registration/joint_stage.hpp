#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "mapping/heights/height_field.hpp"
#include "mapping/registration/block_stage.hpp"
#include "mapping/registration/evidence_lattice.hpp"
#include "mapping/registration/fine_stage.hpp"
#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/registrar.hpp"

namespace ceilmap::registration {

/// Registration of images with weak texture, where no single block shows by itself where its
/// content has gone, but all of them together do: the correlation surfaces of all blocks are added
/// under every motion near a predicted one.
///
/// A sample of a phase-only correlation surface, divided by the surface's root mean square, is a
/// standard normal variable z where the block has nothing in common with the current image; z^2/2
/// is the log-likelihood ratio of a common content of unknown strength to none. Its sum over the
/// blocks is the evidence of a motion. A block gives no more than a limited evidence, so that a
/// thing that moved by itself, a lamp switched off, or a shadow does not outweigh the rest.
///
/// Between recordings (RegistrarParams::same_recording false) either sign of z is evidence: a lamp
/// that was bright is dark when switched off, and an edge that is lit from its other side is bright
/// where it was dark.
///
/// Works on a level of half the resolution of the rough one: weak structures are large (edges of
/// the ceiling, lamps, mouldings), and their noise is lower there.
class JointStage {
 public:
  JointStage(cv::Size size, const RegistrarParams& params);

  /// Two prepared images, and the heights of the reference; nullptr: all of it is at the height of
  /// the reference plane.
  struct Images {
    const FrameSpectrum::Data& reference;
    const FrameSpectrum::Data& current;
    const heights::HeightField* heights = nullptr;
  };

  /// Fills data.broad from data.rough, and prepares it as a reference; once, thread-safe.
  void Prepare(FrameSpectrum::Data& data);

  /// The motion near the prior that has most evidence, the prior's own included. The covariance is
  /// that of the images and of the heights: large in directions that the images do not determine,
  /// as along the only edge in view. Scale 1.
  /// @return kOk, kAmbiguous where another motion has nearly as much evidence, or kNoMatch.
  [[nodiscard]] Registration Match(const Images& images, const MotionPrior& prior);

  /// The motion as the images and an expectation together tell it: mean and covariance of the
  /// posterior over the motions near the expected one. Where the images tell nothing it is the
  /// expectation. Scale 1.
  /// @param covariance  of the expectation: (tx_px, ty_px, theta_rad).
  /// @return kOk, or kNoMatch where the images cannot be compared. `peak` as of Match; `runner_up`:
  /// that of the best of motions that are all wrong. Both are 0 where the images tell nothing.
  [[nodiscard]] Registration Posterior(const Images& images,
                                       const ImageMotion& expected,
                                       const Eigen::Matrix3d& covariance);

 private:
  using Lattice = EvidenceLattice;
  using Peak = EvidencePeak;
  /// Correlation surfaces of the blocks at one motion.
  struct Surfaces {
    int measured_at = 0;                   // turn, lattice steps
    std::vector<int> blocks;               // that could be measured
    std::vector<Eigen::Vector2d> centres;  // of their content
    std::vector<float> values;             // standard normal, one surface after the other
  };
  struct Moments {
    double weight = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  };

  [[nodiscard]] ImageMotion MotionOf(int block,
                                     const heights::HeightField* known,
                                     const ImageMotion& start) const;
  bool MeasureSurfaces(const Images& images, const ImageMotion& start, Surfaces& surfaces);
  [[nodiscard]] float Largest(const float* surface) const;
  void LimitBlocks(const Surfaces& surfaces);
  void AddBlock(const Surfaces& surfaces, std::size_t block, int turn, Lattice& lattice);
  void AddBlocks(int turn, Lattice& lattice);
  bool MeasureEvidence(const Images& images,
                       const ImageMotion& start,
                       double same_turn,
                       Lattice& lattice);
  [[nodiscard]] Peak FindPeak(const Lattice& lattice,
                              const ImageMotion& start,
                              const MotionPrior& prior,
                              const Peak* best,
                              const Eigen::Matrix3d& information) const;
  [[nodiscard]] static ImageMotion MotionAt(const Lattice& lattice,
                                            const ImageMotion& start,
                                            const Eigen::Vector3d& at);
  [[nodiscard]] Lattice LatticeFor(double sigma_px, double sigma_rad) const;
  [[nodiscard]] Eigen::Matrix3d FullAxes(const Lattice& lattice, const ImageMotion& start) const;
  [[nodiscard]] std::vector<Eigen::Vector3d> Centres(const Lattice& lattice,
                                                     double sigma_px,
                                                     double sigma_rad) const;
  [[nodiscard]] double Chance() const;
  void Accumulate(const Lattice& lattice,
                  const Eigen::Vector3d& centre,
                  const Eigen::Matrix3d& information,
                  Moments& moments) const;
  [[nodiscard]] int CountAgreeing(const Lattice& lattice, const Peak& peak) const;
  [[nodiscard]] double LogPrior(const MotionPrior& prior, const ImageMotion& motion) const;

  LevelFrame frame_;  // of the level in the full image
  cv::Size rough_size_;
  bool either_contrast_;  // between recordings: what was bright may be dark
  double half_diagonal_px_;
  BlockStage blocks_;
  Eigen::Vector2d principal_px_;              // from the image's centre, level px
  Surfaces middle_;                           // at the start of the last measurement
  std::vector<Surfaces> turned_;              // at turns beside it
  std::vector<float> most_;                   // of each block's surfaces: the largest value
  int compared_ = 0;                          // blocks that were measured at any turn
  std::vector<const Surfaces*> by_distance_;  // scratch
  std::vector<char> added_;                   // scratch
  cv::Mat grey_;                              // scratch
  std::vector<float> row_;                    // scratch
};

}  // namespace ceilmap::registration
