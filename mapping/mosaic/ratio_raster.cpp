#include "mapping/mosaic/ratio_raster.hpp"

#include <algorithm>
#include <thread>
#include <utility>
#include <vector>

#include "calib/base/parallel.hpp"
#include "mapping/mosaic/raster_squares.hpp"

namespace ceilmap::mosaic {

void RatioRaster::AddAround(int col, int row) {
  const int x = squares::Of(col);
  const int y = squares::Of(row);
  for (int v = y - 1; v <= y + 1; ++v) {
    for (int u = x - 1; u <= x + 1; ++u) {
      cv::Mat_<float>& square = squares_[squares::Key(u, v)];
      if (square.empty()) square = cv::Mat_<float>::zeros(squares::kSide, squares::kSide);
    }
  }
}

float RatioRaster::At(int col, int row) const {
  const cv::Point square(squares::Of(col), squares::Of(row));
  const auto found = squares_.find(squares::Key(square.x, square.y));
  if (found == squares_.end()) return 0;
  return found->second(row - squares::kSide * square.y, col - squares::kSide * square.x);
}

cv::Mat RatioRaster::Ratios(const cv::Rect& window) const {
  cv::Mat ratios(window.size(), CV_32FC1);
  for (int row = 0; row < window.height; ++row) {
    auto* values = ratios.ptr<float>(row);
    for (int col = 0; col < window.width; ++col) {
      values[col] = At(window.x + col, window.y + row);
    }
  }
  return ratios;
}

cv::Point2d RatioRaster::PlaceOf(int col, int row) const {
  return {grid_.min_x + (col + 0.5) * grid_.resolution,
          grid_.max_y - (row + 0.5) * grid_.resolution};
}

cv::Rect2d RatioRaster::BoxOf(const cv::Rect& window) const {
  return {grid_.min_x + window.x * grid_.resolution,
          grid_.max_y - window.br().y * grid_.resolution,
          window.width * grid_.resolution,
          window.height * grid_.resolution};
}

cv::Vec2f RatioRaster::Range() const {
  cv::Vec2f range(1, 1);
  bool first = true;
  for (const auto& [key, square] : squares_) {
    for (const float rho : square) {
      if (rho <= 0) continue;
      range[0] = first ? rho : std::min(range[0], rho);
      range[1] = first ? rho : std::max(range[1], rho);
      first = false;
    }
  }
  return range;
}

RatioRaster RatioRaster::Transformed(int threads, const Work& work) const {
  RatioRaster result = *this;  // shares the content until it is replaced
  std::vector<std::pair<std::int64_t, cv::Mat_<float>*>> all;
  all.reserve(result.squares_.size());
  for (auto& [key, square] : result.squares_) all.emplace_back(key, &square);
  std::sort(all.begin(), all.end());  // neighbours use the same images
  if (threads == 0) threads = static_cast<int>(std::thread::hardware_concurrency());
  ParallelFor(static_cast<int>(all.size()), std::max(threads, 1), [&](int i) {
    const auto& [key, square] = all[static_cast<std::size_t>(i)];
    const cv::Rect window(squares::kSide * squares::At(key),
                          cv::Size(squares::kSide, squares::kSide));
    *square = work(window, *square);
  });
  return result;
}

}  // namespace ceilmap::mosaic
