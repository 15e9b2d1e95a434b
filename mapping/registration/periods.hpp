#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "mapping/registration/fft.hpp"

namespace ceilmap::registration {

/// Finds the periods of an image: shifts under which it resembles itself, as a ceiling of tiles
/// does. They are the highest peaks of the autocorrelation, so that a lattice is described by some
/// of its vectors, not by a basis; multiples of one period may be among them.
///
/// Contains an FFT plan and buffers: one object per thread. Internal to the registrar.
class PeriodFinder {
 public:
  explicit PeriodFinder(cv::Size size);

  /// @param image  CV_32FC1 of the size, local mean removed; NaN where it has no content.
  /// @return At most six, the clearest one first, pixels; of p and -p only one. Longer than 0.09
  /// of the longer side, and along each axis shorter than 0.55 of the shorter side. Empty: none.
  [[nodiscard]] std::vector<Eigen::Vector2d> Find(const cv::Mat& image);

 private:
  cv::Mat Autocorrelation(const cv::Mat& weighted);

  cv::Size size_;
  int reach_;  // longest period along each axis, pixels
  PlaneFft fft_;
  cv::Size padded_;
  RealArray plane_;
  ComplexArray spectrum_;
  cv::Mat window_;
  cv::Mat of_window_;  // autocorrelation of the window
};

}  // namespace ceilmap::registration
