#include "app/page/mosaic_picture.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

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

std::vector<unsigned char> Encode(const cv::Mat& picture, bool webp, int quality) {
  std::vector<unsigned char> bytes;
  if (webp) {
    cv::imencode(".webp", picture, bytes, {cv::IMWRITE_WEBP_QUALITY, quality});
  } else {
    cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, 9});
  }
  return bytes;
}

std::vector<unsigned char> EncodeWithin(cv::Mat grey,
                                        cv::Mat alpha,
                                        bool webp,
                                        std::size_t max_bytes) {
  constexpr int kMaxSidePx = 16383;  // limit of WebP
  while (std::max(grey.cols, grey.rows) > kMaxSidePx) Halve(grey, alpha);
  while (true) {
    const cv::Mat picture = WithAlpha(grey, alpha);
    std::vector<unsigned char> bytes;
    for (const int quality : {85, 60, 30}) {
      bytes = Encode(picture, webp, quality);
      if (bytes.size() <= max_bytes) return bytes;
      if (!webp) break;
    }
    if (grey.total() == 1) return bytes;
    Halve(grey, alpha);
  }
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
  const bool webp = cv::haveImageWriter(".webp");
  return {.mime = webp ? "image/webp" : "image/png",
          .bytes = EncodeWithin(grey.clone(), alpha.clone(), webp, max_bytes),
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
