#include "mapping/mosaic/photo_cost.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/mosaic/padded_image.hpp"

namespace ceilmap::mosaic {
namespace {

constexpr std::size_t kMaxViews = 5;
constexpr int kSide = 5;            // samples of a patch
constexpr double kSpacingPx = 2.5;  // between samples, image pixels
constexpr float kScale = 5;         // mean difference of cost 1, grey levels
constexpr double kMargin = 2;       // pixels of the image around a patch

constexpr std::size_t kSamples = std::size_t{kSide} * kSide;
using Patch = std::array<float, kSamples>;

}  // namespace

PhotoCost::PhotoCost(std::vector<PhotoView> views,
                     const store::MosaicGrid& grid,
                     cv::Size view_size,
                     double units_per_px)
    : views_(std::move(views)), grid_(grid), view_size_(view_size), units_per_px_(units_per_px) {}

void PhotoCost::Select(int col, int row, float rho) {
  at_ = {grid_.min_x + (col + 0.5) * grid_.resolution,
         grid_.max_y - (row + 0.5) * grid_.resolution};
  order_.clear();
  for (std::size_t k = 0; k < views_.size(); ++k) {
    const cv::Point2d pixel = views_[k].placement->ToPixel(at_.x, at_.y, rho);
    const double border = std::min(
        {pixel.x, pixel.y, view_size_.width - 1 - pixel.x, view_size_.height - 1 - pixel.y});
    if (border > kMargin) order_.emplace_back(-border, static_cast<int>(k));
  }
  const std::size_t count = std::min(kMaxViews, order_.size());
  std::partial_sort(
      order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(count), order_.end());
  selected_.clear();
  for (std::size_t i = 0; i < count; ++i) selected_.push_back(order_[i].second);
}

float PhotoCost::Cost(float rho) const {
  std::array<Patch, kMaxViews> patches;
  std::size_t count = 0;
  const double reach = kSpacingPx * (kSide - 1) * 0.5 * units_per_px_;
  for (const int k : selected_) {
    const PhotoView& view = views_[static_cast<std::size_t>(k)];
    const cv::Point2d middle = view.placement->ToPixel(at_.x, at_.y, rho);
    const cv::Point2d corner = view.placement->ToPixel(at_.x - reach, at_.y - reach, rho);
    const cv::Point2d across =
        (view.placement->ToPixel(at_.x + reach, at_.y - reach, rho) - corner) / (kSide - 1);
    const cv::Point2d up(-across.y, across.x);
    const double extent = 1.5 * cv::norm(middle - corner);
    if (middle.x < extent || middle.y < extent || middle.x > view_size_.width - 1 - extent ||
        middle.y > view_size_.height - 1 - extent) {
      continue;
    }
    Patch& patch = patches[count++];
    for (int j = 0; j < kSide; ++j) {
      for (int i = 0; i < kSide; ++i) {
        const cv::Point2d pixel = corner + i * across + j * up;
        patch[static_cast<std::size_t>(j * kSide + i)] = view.gain * Sample(*view.image, pixel);
      }
    }
  }
  if (count < 2) return 1;
  std::array<float, kMaxViews> costs{};
  for (std::size_t k = 1; k < count; ++k) {
    float sum = 0;
    for (std::size_t i = 0; i < kSamples; ++i) sum += std::abs(patches[k][i] - patches[0][i]);
    costs[k - 1] = std::min(sum / (kSamples * kScale), 1.0F);
  }
  const std::size_t used = count / 2;
  std::sort(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(count - 1));
  float mean = 0;
  for (std::size_t k = 0; k < used; ++k) mean += costs[k] / static_cast<float>(used);
  return mean;
}

}  // namespace ceilmap::mosaic
