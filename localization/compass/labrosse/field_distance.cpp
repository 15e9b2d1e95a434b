#include "localization/compass/labrosse/field_distance.hpp"

#include <algorithm>
#include <cmath>

#include "localization/compass/panorama.hpp"
#include "localization/compass/sum_of_squares.hpp"

namespace ceilmap::labrosse {

FieldDistance::FieldDistance(const cv::Mat& reference,
                             const cv::Mat& current,
                             std::span<const float> weights)
    : reference_(reference), current_(current) {
  compass::CheckPanoramas(reference, current);
  const int width = current.cols;
  for (int u = 0; u < width; ++u) {
    if (weights[static_cast<std::size_t>(u)] == 0) continue;
    if (!runs_.empty() && runs_.back().end == u) {
      runs_.back().end = u + 1;
    } else {
      runs_.push_back({u, u + 1});
    }
  }
}

std::uint64_t FieldDistance::Squared(int columns) const {
  const int width = current_.cols;
  const std::size_t pixel_bytes = current_.elemSize();
  const auto add = [&](int v, int begin, int end, int reference_begin) {
    const auto count = static_cast<std::size_t>(end - begin) * pixel_bytes;
    return compass::SumOfSquares(current_.ptr(v, begin), reference_.ptr(v, reference_begin), count);
  };
  std::uint64_t sum = 0;
  for (const auto& [begin, end] : runs_) {
    // Column u is compared with the reference's column u - columns; from `wrap` on, this index
    // starts again at 0.
    const int from = ((begin - columns) % width + width) % width;
    const int wrap = std::min(end, begin + width - from);
    for (int v = 0; v < current_.rows; ++v) {
      sum += add(v, begin, wrap, from);
      if (wrap < end) sum += add(v, wrap, end, 0);
    }
  }
  return sum;
}

double RowTexture(const cv::Mat& panorama, std::span<const float> weights) {
  const int channels = panorama.channels();
  double squares = 0;
  double pixels = 0;
  for (int v = 0; v < panorama.rows; ++v) {
    const std::uint8_t* row = panorama.ptr(v);
    for (int c = 0; c < channels; ++c) {
      double count = 0;
      double sum = 0;
      double sum2 = 0;
      for (int u = 0; u < panorama.cols; ++u) {
        if (weights[static_cast<std::size_t>(u)] == 0) continue;
        const double value = row[u * channels + c];
        count += 1;
        sum += value;
        sum2 += value * value;
      }
      if (count == 0) return 0;
      squares += sum2 - sum * sum / count;
      pixels += count;
    }
  }
  return std::sqrt(std::max(squares, 0.0) / pixels);
}

}  // namespace ceilmap::labrosse
