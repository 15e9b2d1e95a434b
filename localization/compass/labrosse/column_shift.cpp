#include "localization/compass/labrosse/column_shift.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "localization/compass/sum_of_squares.hpp"

namespace ceilmap::labrosse {

std::vector<std::uint64_t> SquaredShiftDistances(const cv::Mat& reference, const cv::Mat& current) {
  compass::CheckPanoramas(reference, current);
  const auto width = static_cast<std::size_t>(current.cols);
  const std::size_t pixel_bytes = current.elemSize();
  const std::size_t row_bytes = width * pixel_bytes;
  std::vector<std::uint64_t> squared(width, 0);
  // With the reference's row stored twice in succession, every circular shift of it is one run of
  // bytes.
  std::vector<std::uint8_t> twice(2 * row_bytes);
  for (int v = 0; v < current.rows; ++v) {
    std::copy_n(reference.ptr(v), row_bytes, twice.begin());
    std::copy_n(
        reference.ptr(v), row_bytes, twice.begin() + static_cast<std::ptrdiff_t>(row_bytes));
    for (std::size_t shift = 0; shift < width; ++shift) {
      const std::uint8_t* shifted = twice.data() + (width - shift) * pixel_bytes;
      squared[shift] += compass::SumOfSquares(current.ptr(v), shifted, row_bytes);
    }
  }
  return squared;
}

std::optional<int> LeastShift(const std::vector<std::uint64_t>& squared) {
  const int width = static_cast<int>(squared.size());
  const auto signed_shift = [width](int shift) {
    return 2 * shift > width ? shift - width : shift;
  };
  const auto least = std::min_element(squared.begin(), squared.end());
  const auto ties = std::count(least, squared.end(), *least);
  const int first = static_cast<int>(least - squared.begin());
  if (ties == 1) return signed_shift(first);
  if (ties > 2 || width == 2) return std::nullopt;
  const int second =
      static_cast<int>(std::find(least + 1, squared.end(), *least) - squared.begin());
  if (second - first != 1 && second - first != width - 1) return std::nullopt;
  const int a = signed_shift(first);
  const int b = signed_shift(second);
  return std::abs(b) < std::abs(a) ? b : a;
}

std::optional<ColumnShift> FindColumnShift(const cv::Mat& reference, const cv::Mat& current) {
  const std::vector<std::uint64_t> squared = SquaredShiftDistances(reference, current);
  const std::optional<int> shift = LeastShift(squared);
  if (!shift) return std::nullopt;
  const int width = current.cols;
  const auto index = static_cast<std::size_t>(*shift < 0 ? *shift + width : *shift);
  return ColumnShift{.columns = *shift,
                     .heading_change_rad = std::numbers::pi * (2.0 * *shift / width),
                     .distance = std::sqrt(static_cast<double>(squared[index]))};
}

}  // namespace ceilmap::labrosse
