#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace ceilmap::change {

/// Brightness of an image relative to the map: log(image / map), a polynomial of second degree over
/// the image. It covers exposure, vignetting and light that varies slowly; lamps that are off or
/// sun patches are what deviates from it.
class BrightnessFit {
 public:
  struct Sample {
    cv::Point2d at;        ///< any unit
    double log_ratio = 0;  ///< log(image / map)
  };

  BrightnessFit() = default;
  /// Robust least squares (Tukey), so that a third of the samples may deviate.
  /// @param extent  of the samples, for scaling; not empty. With fewer than 12 samples the median
  /// is used; without any, 0.
  BrightnessFit(const std::vector<Sample>& samples, const cv::Rect2d& extent);

  [[nodiscard]] double LogRatio(const cv::Point2d& at) const;

 private:
  using Terms = Eigen::Matrix<double, 6, 1>;
  [[nodiscard]] Terms TermsAt(const cv::Point2d& at) const;

  cv::Point2d centre_;
  double scale_ = 1;
  Terms weights_ = Terms::Zero();
};

}  // namespace ceilmap::change
