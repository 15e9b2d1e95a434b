#include "mapping/mosaic/levelling.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ceilmap::mosaic {
namespace {

cv::Mat FeatherWeights(cv::Size size, const cv::Mat& mask, double power) {
  cv::Mat padded(size.height + 2, size.width + 2, CV_8UC1, cv::Scalar(0));
  const cv::Rect inner_rect(1, 1, size.width, size.height);
  cv::Mat inner = padded(inner_rect);
  if (mask.empty()) {
    inner.setTo(255);
  } else {
    mask.copyTo(inner);
  }
  cv::Mat distance;
  cv::distanceTransform(padded, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  distance = distance(inner_rect).clone();
  double largest = 0;
  cv::minMaxLoc(distance, nullptr, &largest);
  cv::Mat weights;
  cv::pow(distance / std::max(largest, 1.0), power, weights);
  // High powers must not underflow to 0 (no content) at the border.
  cv::max(weights, 1e-12, weights);
  weights.setTo(0, inner == 0);
  return weights;
}

}  // namespace

cv::Mat MakeShading(cv::Size size,
                    const cv::Mat& mask,
                    double power,
                    const ExposureModel& exposure) {
  const cv::Mat weights = FeatherWeights(size, mask, power);
  cv::Mat shading(size, CV_32FC2);
  const double centre_u = (size.width - 1) / 2.0;
  const double centre_v = (size.height - 1) / 2.0;
  const double corner = std::max(centre_u * centre_u + centre_v * centre_v, 1.0);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const double du = u - centre_u;
      const double dv = v - centre_v;
      const double q = (du * du + dv * dv) / corner;
      shading.at<Shading>(v, u) = {weights.at<float>(v, u),
                                   static_cast<float>(std::exp(-exposure.LogVignetting(q)))};
    }
  }
  return shading;
}

}  // namespace ceilmap::mosaic
