#include "mapping/mosaic/sharpness.hpp"

#include <opencv2/imgproc.hpp>

namespace ceilmap::mosaic {

double Sharpness(const cv::Mat& image) {
  if (image.cols < 8 || image.rows < 8) return 0;
  cv::Mat half;
  cv::resize(image, half, {}, 0.5, 0.5, cv::INTER_AREA);
  cv::Mat derivative;
  double first = 0;
  for (const int along_x : {0, 1}) {
    cv::Sobel(half, derivative, CV_16S, along_x, 1 - along_x);
    first += cv::norm(derivative, cv::NORM_L2SQR);
  }
  cv::Laplacian(half, derivative, CV_16S, 3);
  return first > 0 ? cv::norm(derivative, cv::NORM_L2SQR) / first : 0;
}

}  // namespace ceilmap::mosaic
