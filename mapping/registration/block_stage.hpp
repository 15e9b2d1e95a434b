#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "mapping/registration/fft.hpp"
#include "mapping/registration/frame_data.hpp"
#include "mapping/registration/kernels.hpp"
#include "mapping/registration/motion_fit.hpp"
#include "mapping/registration/plane_motion.hpp"
#include "mapping/registration/poc.hpp"
#include "mapping/registration/sampling_error.hpp"

namespace ceilmap::registration {

/// The blocks of a BlockStage.
struct BlockGrid {
  int block_px = 64;  ///< side of a block; an even fast FFT size, a multiple of 4
  int blocks = 90;    ///< the grid is laid out for about this many; they overlap by half at most
  /// Where the level keeps the blocks of this grid.
  std::vector<ReferenceBlock> Level::*of_level = &Level::blocks;
  /// A slope of the grey levels is shading of the lens or of a lamp. It looks alike everywhere, so
  /// with it a block agrees with any motion from which it is compared. In small blocks it is also a
  /// part of what they show.
  bool removes_slope = true;
};

/// Blocks that are not among the chosen ones, in their order.
std::vector<int> Without(std::vector<int> blocks, const std::vector<int>& chosen);

/// The fine stage: block POC. A grid of small blocks of the reference is compared with the current
/// image sampled under an approximate motion; each block gives the remaining shift, to a few
/// hundredths of a pixel (peak of the band-limited phase-only correlation, Takita et al. 2003; with
/// a Gaussian spectral weight its peak is a Gaussian, whose maximum is computed in closed form from
/// the logarithms around the highest sample).
///
/// The window biases a shift towards zero; sampling again with the corrected motion removes the
/// bias, because the remaining shift converges to zero.
///
/// Works on one Level: pixels, motions and shifts are those of the level's image, positions
/// relative to its centre.
class BlockStage {
 public:
  /// @param mask  See RegistrarParams::mask, of the level's size; empty: images have content
  /// everywhere. @param same_recording  RegistrarParams::same_recording.
  explicit BlockStage(cv::Size size,
                      const cv::Mat& mask = {},
                      const BlockGrid& grid = {},
                      bool same_recording = true);

  [[nodiscard]] int GridSize() const { return static_cast<int>(corners_.size()); }
  /// Columns and rows of the grid, block = row * columns + column.
  [[nodiscard]] cv::Size Grid() const { return grid_; }
  [[nodiscard]] cv::Rect Area(int block) const;  ///< of a block of the reference
  /// Of a block of the reference, from the image's centre, pixels.
  [[nodiscard]] Eigen::Vector2d Centre(int block) const;

  /// Of a block, along each axis.
  [[nodiscard]] const std::vector<float>& WindowAlongAxis() const { return poc_.WindowX(); }

  /// Fills level.blank. @param mask  Of the level's size, 0 where this image has no content in
  /// addition to the common mask; empty: none.
  void TakeMask(const cv::Mat& mask, Level& level) const;

  /// Integral (CV_32S) of the pixels without content; empty: all have content.
  [[nodiscard]] const cv::Mat& BlankOf(const Level& level) const {
    return level.blank.empty() ? blank_ : level.blank;
  }

  /// Fills level.blocks: afterwards the level can be a reference.
  void PrepareReference(Level& level);

  /// The blocks of the reference that lie inside the current image under `motion`, at most `count`,
  /// spread over the image, the blocks with the most texture of each neighbourhood first.
  std::vector<int> Select(const Level& reference,
                          const Level& current,
                          const ImageMotion& motion,
                          int count) const;

  /// Shifts of the selected blocks. @param search_px  The peak is searched within this distance.
  void Measure(const Level& reference,
               const Level& current,
               const ImageMotion& motion,
               const std::vector<int>& chosen,
               int search_px,
               std::vector<BlockShift>& shifts);

  /// The correlation surface of a block within +-reach pixels of `motion` (PocPlane::Normalized).
  /// @return false where it cannot be compared.
  bool Correlate(const Level& reference,
                 const Level& current,
                 const ImageMotion& motion,
                 int block,
                 int reach,
                 float* surface);

  /// See Dissimilarity. @param noise_power  Expected difference of a pixel, grey levels squared.
  Dissimilarity Compare(const Level& reference,
                        const Level& current,
                        const ImageMotion& motion,
                        double noise_power);

  /// Shifts of the selected blocks under a plane motion, each block sampled with the motion's
  /// linear part at its centre; the motion is that of the level's image and camera.
  /// @param rho  inverse height ratio of each selected block (PlaneMotion::Apply); empty: all 1.
  /// @param passes  how often a block is measured, each time from where the last one found it: for
  ///   shifts that no correction of the motion will remove.
  void MeasurePlane(const Level& reference,
                    const Level& current,
                    const PlaneCamera& camera,
                    const PlaneMotion& motion,
                    const std::vector<int>& chosen,
                    int search_px,
                    std::vector<PlaneShift>& shifts,
                    std::span<const double> rho = {},
                    int passes = 1);

 private:
  [[nodiscard]] kernels::BlockWindow Window() const;
  void SampleBlock(const Level& level, const kernels::Affine& map, RealArray& samples) const;
  void CopyBlock(const Level& level, cv::Point corner, RealArray& samples) const;
  bool TransformBlock(const Level& current, const kernels::Affine& map);
  [[nodiscard]] double NoisePower(const Level& reference, const Level& current) const;
  bool MeasureBlock(const Level& reference,
                    const Level& current,
                    int block,
                    const kernels::Affine& map,
                    int search_px,
                    BlockShift& shift);
  [[nodiscard]] bool IsBlank(const RealArray& samples) const;
  [[nodiscard]] bool Usable(const Level& reference, int block) const;
  [[nodiscard]] bool Inside(const kernels::Affine& map, const Level& level) const;
  static cv::Mat IntegralOf(const cv::Mat& blank);
  void LayOutGrid(int blocks);

  std::vector<ReferenceBlock> Level::*blocks_;
  int block_px_;
  bool removes_slope_;
  bool same_recording_;
  cv::Size size_;
  cv::Mat any_blank_;  // 255 where no image has content; empty: nowhere
  cv::Mat blank_;      // its integral
  cv::Size grid_;
  std::vector<cv::Point> corners_;
  PocPlane poc_;
  SamplingError sampling_error_;
  RealArray samples_;
  ComplexArray spectrum_;
};

}  // namespace ceilmap::registration
