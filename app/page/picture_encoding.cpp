#include "app/page/picture_encoding.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

namespace ceilmap::page {
namespace {

std::vector<unsigned char> Encode(const cv::Mat& picture, bool webp, int quality) {
  std::vector<unsigned char> bytes;
  if (webp) {
    cv::imencode(".webp", picture, bytes, {cv::IMWRITE_WEBP_QUALITY, quality});
  } else {
    cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, 9});
  }
  return bytes;
}

}  // namespace

EncodedPicture EncodeWithin(const std::function<cv::Mat()>& picture,
                            const std::function<void()>& halve,
                            std::initializer_list<int> qualities,
                            std::size_t max_bytes) {
  constexpr int kMaxSidePx = 16383;  // limit of WebP
  const bool webp = cv::haveImageWriter(".webp");
  EncodedPicture encoded{webp ? "image/webp" : "image/png", {}};
  while (true) {
    const cv::Mat now = picture();
    if (std::max(now.cols, now.rows) <= kMaxSidePx) {
      for (const int quality : qualities) {
        encoded.bytes = Encode(now, webp, quality);
        if (encoded.bytes.size() <= max_bytes) return encoded;
        if (!webp) break;
      }
    }
    if (now.total() == 1) return encoded;
    halve();
  }
}

}  // namespace ceilmap::page
