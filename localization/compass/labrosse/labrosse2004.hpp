#pragma once

#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "localization/compass/compass.hpp"
#include "localization/compass/frame_check.hpp"

namespace ceilmap::labrosse {

struct Labrosse2004Params {
  /// A panorama that changes less than this along its rows (RowTexture, grey levels, >= 0) tells
  /// nothing: it is uniform but for noise.
  double min_texture = 2;
  /// Width over which the differences of two panoramas are one error, rad, > 0. Only the variance
  /// depends on it; as measured for Labrosse2006Params.
  double independent_rad = std::numbers::pi / 45;
  /// While nothing can be measured: standard deviation of the rate at which the robot may turn,
  /// rad/s, > 0.
  double unseen_rate_rad_s = 0.5;

  void Validate() const;  ///< throws InputError naming field, value and range
};

/// The compass of Labrosse, "Visual compass", TAROS 2004: the heading changes by the whole number
/// of columns that brings two successive panoramas closest, over all shifts and all columns, and
/// the changes add up. Panoramas of 360 columns in the paper, any width here.
///
/// Turns of less than half a column a frame are never seen, and travel past things at the sides is
/// taken for turns. The variance knows the first (1/12 column^2 a frame), not the second.
///
/// A panorama without an answer (uniform, or the same several times around) leaves the heading as
/// it is; the next one is compared with the last that was usable.
/// Time: columns^2 x rows x channels.
class Labrosse2004 : public compass::Compass {
 public:
  explicit Labrosse2004(const Labrosse2004Params& params = {});

  std::optional<compass::HeadingEstimate> Next(const compass::PanoramaFrame& frame) override;
  [[nodiscard]] compass::DistanceProfile Profile() const override;
  [[nodiscard]] std::int64_t References() const override { return references_; }

 private:
  bool Turn();
  void Hold(double stamp_s);
  void MakeReference(double stamp_s);

  Labrosse2004Params params_;
  compass::FrameCheck check_;
  cv::Mat current_;
  cv::Mat reference_;  ///< empty: nothing usable was seen yet
  std::int64_t reference_frame_ = 0;
  compass::HeadingEstimate at_reference_;
  double reference_stamp_s_ = 0;  ///< or the first frame's
  compass::HeadingEstimate estimate_;
  std::vector<std::uint64_t> squared_;
  std::int64_t compared_frame_ = 0;
  int shift_columns_ = 0;
  std::int64_t references_ = 0;
};

}  // namespace ceilmap::labrosse
