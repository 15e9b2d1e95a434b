#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "localization/compass/colour/colour_classes.hpp"
#include "localization/compass/colour/exposure_belief.hpp"
#include "localization/compass/colour/line_features.hpp"
#include "localization/compass/colour/scan_lines.hpp"

namespace ceilmap::colour {

/// Features of a frame under one assumed exposure.
struct Reading {
  LineFeatures features;
  double probability = 1;  ///< of that exposure
};

/// Reads the scan lines of frames at all probable exposures relative to the model: one once the
/// exposure is known, two or three when the illumination changes. Costs about 15 us per reading.
class FrameReader {
 public:
  /// @param sigma, drift  ColourCompassParams::exposure_sigma and exposure_drift.
  FrameReader(const std::vector<ColourClass>& classes, double sigma, double drift);

  /// Advances time by the interval since the previous frame.
  void Wait(double seconds);
  /// @param samples  Samples from ScanLines::Sample.
  void Read(const cv::Mat& samples, const ScanLines& lines);
  /// Readings of the last Read; at least one.
  [[nodiscard]] std::span<const Reading> Readings() const { return readings_; }
  /// Updates the probabilities of the exposures.
  /// @param log_likelihood  One for each of Readings().
  void Weigh(std::span<const double> log_likelihood);
  /// The reading at the most likely exposure.
  [[nodiscard]] const Reading& Best() const;
  /// Returns to the initial state.
  void Reset() { exposure_ = ExposureBelief(sigma_); }

 private:
  ColourClasses classes_;
  double sigma_;
  double drift_;
  ExposureBelief exposure_;
  std::array<cv::Mat, ExposureBelief::kFactors> levels_;  // one table for cv::LUT each
  std::vector<int> factors_;                              // of the readings
  std::vector<Reading> readings_;
  cv::Mat exposed_;  // scratch
};

}  // namespace ceilmap::colour
