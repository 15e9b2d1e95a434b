#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace ceilmap::labrosse {

/// Squared Euclidean distances of a panorama to a reference at single shifts, over the columns of
/// the panorama that lie in the fields of view. Defined as in SquaredShiftDistances: exact
/// integers. Intended for searches that need a few shifts; for all of them see ShiftDistances.
class FieldDistance {
 public:
  /// @param reference, current  CV_8UC1 or CV_8UC3. Kept by reference count, not copied.
  /// @param weights  One per column of `current`: a column is used fully where its weight is not 0,
  ///   and not at all elsewhere.
  /// @throws InputError on panoramas that no compass accepts, or that differ in size or type.
  FieldDistance(const cv::Mat& reference, const cv::Mat& current, std::span<const float> weights);

  /// @param columns  Number of columns by which the reference's content moved to the right, any
  ///   integer.
  [[nodiscard]] std::uint64_t Squared(int columns) const;

 private:
  struct Run {
    int begin;
    int end;
  };

  cv::Mat reference_;
  cv::Mat current_;
  std::vector<Run> runs_;  ///< the runs of columns that are used
};

/// Amount of texture in the fields of view: root mean square deviation, grey levels, of the pixels
/// from the mean of their row (in those fields, each channel separately). Content that does not
/// change along the rows gives no heading information. 0 if no column is used.
/// @param panorama  CV_8UC1 or CV_8UC3.
/// @param weights  As above.
double RowTexture(const cv::Mat& panorama, std::span<const float> weights);

}  // namespace ceilmap::labrosse
