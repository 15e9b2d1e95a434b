#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "localization/compass/compass.hpp"
#include "localization/compass/frame_check.hpp"

namespace ceilmap::labrosse {

/// The compass of Labrosse, "Visual compass", TAROS 2004. The change of heading is the whole number
/// of columns that minimizes the distance of two successive panoramas, over all shifts and all
/// columns; the changes are summed. Panoramas of 360 columns in the paper, any width here.
///
/// Turns of less than half a column per frame are not detected, and travel past objects at the
/// sides is measured as turns. The variance includes the first error (1/12 column^2 per frame), not
/// the second.
///
/// A panorama without a result (uniform, or periodic around the circle) leaves the heading
/// unchanged; the next panorama is compared with the last usable one.
/// Time: columns^2 x rows x channels.
class Labrosse2004 : public compass::Compass {
 public:
  std::optional<compass::HeadingEstimate> Next(const compass::PanoramaFrame& frame) override;
  [[nodiscard]] compass::DistanceProfile Profile() const override;
  [[nodiscard]] std::int64_t References() const override { return references_; }

 private:
  bool Turn();
  void Hold(double stamp_s);
  void MakeReference(double stamp_s);

  compass::FrameCheck check_;
  cv::Mat current_;
  cv::Mat reference_;  ///< empty: no usable panorama so far
  std::int64_t reference_frame_ = 0;
  compass::HeadingEstimate at_reference_;
  double reference_stamp_s_ = 0;  ///< or stamp of the first frame
  compass::HeadingEstimate estimate_;
  std::vector<std::uint64_t> squared_;
  std::int64_t compared_frame_ = 0;
  int shift_columns_ = 0;
  std::int64_t references_ = 0;
};

}  // namespace ceilmap::labrosse
