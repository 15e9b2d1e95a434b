#include "app/page/mosaic_picture.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "app/page/picture_encoding.hpp"

namespace ceilmap::page {
namespace {

// Grey, grey, grey, alpha, as both encoders need it. Unmapped pixels are black, which compresses
// best.
cv::Mat WithAlpha(const cv::Mat& grey, const cv::Mat& alpha) {
  cv::Mat seen = cv::Mat::zeros(grey.size(), CV_8UC1);
  grey.copyTo(seen, alpha);
  cv::Mat picture;
  cv::merge(std::vector<cv::Mat>{seen, seen, seen, alpha}, picture);
  return picture;
}

// Half the resolution. Each pixel is the mean of the mapped pixels only, so that edges do not
// darken.
void Halve(cv::Mat& grey, cv::Mat& alpha) {
  const cv::Size size(std::max(1, grey.cols / 2), std::max(1, grey.rows / 2));
  cv::Mat weighted;
  cv::multiply(grey, alpha, weighted, 1, CV_32F);
  cv::resize(weighted, weighted, size, 0, 0, cv::INTER_AREA);
  cv::Mat weight;
  alpha.convertTo(weight, CV_32F);
  cv::resize(weight, weight, size, 0, 0, cv::INTER_AREA);
  weight.convertTo(alpha, CV_8U);
  cv::max(weight, 1e-3, weight);
  cv::divide(weighted, weight, grey, 1, CV_8U);
}

}  // namespace

PagePicture MakePicture(const cv::Mat& grey,
                        const cv::Mat& alpha,
                        const store::MosaicGrid& grid,
                        std::size_t max_bytes) {
  if (grid.width_px == 0 || grid.height_px == 0) return {};
  const cv::Size size(grid.width_px, grid.height_px);
  if (grey.type() != CV_8UC1 || alpha.type() != CV_8UC1 || grey.size() != size ||
      alpha.size() != size) {
    throw std::invalid_argument("MakePicture: grey and alpha must be CV_8UC1 of the grid's size");
  }
  cv::Mat reduced = grey.clone();
  cv::Mat reduced_alpha = alpha.clone();
  EncodedPicture encoded = EncodeWithin([&] { return WithAlpha(reduced, reduced_alpha); },
                                        [&] { Halve(reduced, reduced_alpha); },
                                        {85, 60, 30},
                                        max_bytes);
  return {.mime = std::move(encoded.mime),
          .bytes = std::move(encoded.bytes),
          .min_x = grid.min_x,
          .min_y = grid.max_y - grid.resolution * grid.height_px,
          .max_x = grid.min_x + grid.resolution * grid.width_px,
          .max_y = grid.max_y};
}

PagePicture MakeMosaicPicture(const store::MapReader& map, int max_px, std::size_t max_bytes) {
  cv::Mat grey;
  cv::Mat alpha;
  const store::MosaicGrid grid = map.ReadOverview(max_px, grey, alpha);
  return MakePicture(grey, alpha, grid, max_bytes);
}

}  // namespace ceilmap::page
